// SPDX-License-Identifier: GPL-3.0-or-later
// Measures a proxy against the full-detail surface below it, both ways, at deterministic area-stratified samples and
// at vertices (Cignoni, Rocchini & Scopigno 1998, "Metro"). The largest distance is a bound over all points, not only
// over samples. Thread-safe: no state.
#pragma once

#include <span>
#include <vector>

#include "baker/distance/distance_bvh.h"
#include "baker/scene/lattice_mesh.h"
#include "baker/scene/scene.h"

namespace zc {

struct SurfaceError {
  double max_m = 0;   // no point of either surface is farther from the other
  double mean_m = 0;  // over area samples of both surfaces
  double normal_deviation_deg =
      0;                   // largest, 0..90, of unsigned normals between an area sample and the closest surface
  double color_error = 0;  // mean absolute linear RGB difference, 0..1
  // Largest distance, over area samples of another appearance than the closest surface, to where the appearance is
  // right: on the other side to the sample's own appearance, or on its own side to the appearance it was given,
  // whichever is nearer. Half the width of a window that vanished in its wall, say.
  double appearance_m = 0;
  std::uint64_t work = 0;  // that measuring took
  bool is_loose = false;  // measuring took all the work that it may: the distances are bounds still, but not close ones
};

// Of several surfaces together: means are weighted by their areas.
class ErrorSum {
 public:
  void add(const SurfaceError& error, double area);
  [[nodiscard]] SurfaceError joint() const;

 private:
  SurfaceError sum_;  // means: times the area
  double area_ = 0;
};

double area_of(const LatticeMesh& mesh);  // square steps

struct DetailSurface {
  const LatticeMesh* mesh = nullptr;
  const DistanceBvh* bvh = nullptr;
  double moved = 0;  // no point of the mesh is farther from the source, nor one of the source from the mesh; steps
};

// Which of them has the nearest box to p: it usually settles all others.
std::size_t nearest_box(std::span<const DetailSurface> surfaces, const glm::dvec3& p);

// Class of each material: materials of one class are hard to distinguish.
std::vector<std::uint16_t> appearance_classes(std::span<const Material> materials);

// appearances: appearance_classes(materials). promise_m: a bound of the distance that the proxy was made to keep; 0:
// none.
SurfaceError measure_proxy(const LatticeMesh& proxy, std::span<const DetailSurface> detail,
                           std::span<const Material> materials, std::span<const std::uint16_t> appearances,
                           double step_m, double promise_m = 0);

}  // namespace zc
