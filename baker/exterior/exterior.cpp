// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/exterior/exterior.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <utility>
#include <vector>

#include "baker/light/light_scene.h"
#include "baker/light/light_threads.h"
#include "baker/repair/union_find.h"

namespace zc {
namespace {

constexpr float kFarM = 1e6F;
constexpr float kInsetM = 0.02F;  // of points from the rim of their face
constexpr float kSpacingM = 0.25F;
constexpr int kFewRows = 4;  // of a face's points
constexpr int kManyRows = 32;
constexpr std::size_t kBlock = 64;  // sides that a thread takes at a time
// Sides between two updates of what is known: an opening that one of them finds spares the others.
constexpr std::size_t kSidesAtOnce = 2048;

// Sides of faces, 2 f in front and 2 f + 1 behind, and the open; those that are joined face one space.
class Spaces {
 public:
  explicit Spaces(std::size_t faces) : open_(static_cast<std::uint32_t>(2 * faces)), sets_(2 * faces + 1) {}

  [[nodiscard]] std::uint32_t open() const { return open_; }
  std::uint32_t find(std::uint32_t side) { return sets_.find(side); }
  void join(std::uint32_t a, std::uint32_t b) { sets_.join(a, b); }
  bool is_open(std::uint32_t side) { return find(side) == find(open_); }

 private:
  std::uint32_t open_;
  UnionFind sets_;
};

using Packet = std::array<glm::vec3, LightScene::kPacket>;

// Evenly over the half of the sphere above z, and so that those of the k-th points lie between each other.
Packet make_directions(std::uint32_t k) {
  Packet out{};
  const float offset = std::fmod(0.618034F * static_cast<float>(k), 1.0F);
  for (std::size_t i = 0; i < out.size(); ++i) {
    const float z = (static_cast<float>(i) + offset) / static_cast<float>(out.size());
    const float around = static_cast<float>(k) + 2.3999632F * static_cast<float>(i);  // the golden angle
    const float r = std::sqrt(std::max(0.0F, 1 - z * z));
    out[i] = {r * std::cos(around), r * std::sin(around), z};
  }
  return out;
}

class Exterior {
 public:
  Exterior(const LatticeMesh& mesh, double step_m, unsigned threads)
      : mesh_(mesh),
        threads_(threads),
        detail_(mesh, step_m),
        spaces_(mesh.faces.size()),
        seen_(2 * mesh.faces.size()) {}

  // Per face.
  Result<std::vector<bool>> visible() {
    ZC_ASSIGN(const LightDevice device, LightDevice::create());
    constexpr std::array<std::uint32_t, 1> kAll = {0};
    ZC_ASSIGN(const LightScene scene, LightScene::build(device, detail_, kAll, {glm::dvec3(0), detail_.bias_m}));
    scene_ = &scene;
    const auto faces = static_cast<std::uint32_t>(mesh_.faces.size());
    std::vector<std::uint32_t> sides;
    for (std::uint32_t f = 0; f < faces; ++f)
      if (!mesh_.faces[f].ground) sides.push_back(2 * f);
    // Most faces are seen at once from their fronts; what few rays leave sealed gets many.
    row_limit_ = kFewRows;
    trace_from(sides);
    while (!(sides = unknown_sides()).empty()) trace_from(sides);
    row_limit_ = kManyRows;
    seen_.assign(seen_.size(), false);
    while (!(sides = unknown_sides()).empty()) trace_from(sides);
    std::vector<bool> out(faces);
    for (std::uint32_t f = 0; f < faces; ++f)
      out[f] = mesh_.faces[f].ground || spaces_.is_open(2 * f) || spaces_.is_open(2 * f + 1);
    return out;
  }

 private:
  using Pair = std::pair<std::uint32_t, std::uint32_t>;

  // Those without rays yet that share a space with a side of a face that is not known to be seen.
  std::vector<std::uint32_t> unknown_sides() {
    std::vector<bool> wanted(spaces_.open() + std::size_t{1});
    for (std::uint32_t f = 0; f < mesh_.faces.size(); ++f) {
      if (mesh_.faces[f].ground || spaces_.is_open(2 * f) || spaces_.is_open(2 * f + 1)) continue;
      wanted[spaces_.find(2 * f)] = wanted[spaces_.find(2 * f + 1)] = true;
    }
    std::vector<std::uint32_t> out;
    for (std::uint32_t side = 0; side < spaces_.open() && out.size() < kSidesAtOnce; ++side)
      if (!seen_[side] && wanted[spaces_.find(side)]) out.push_back(side);
    return out;
  }

  void trace_from(const std::vector<std::uint32_t>& sides) {
    for (const std::uint32_t side : sides) seen_[side] = true;
    std::vector<std::vector<Pair>> joined((sides.size() + kBlock - 1) / kBlock);
    for_each_on_threads(joined.size(), threads_, [&](std::size_t block) {
      for (std::size_t i = block * kBlock; i < std::min(sides.size(), (block + 1) * kBlock); ++i)
        trace_side(sides[i], joined[block]);
    });
    for (const auto& pairs : joined)
      for (const auto& [a, b] : pairs) spaces_.join(a, b);
  }

  // Until a ray gets out.
  void trace_side(std::uint32_t side, std::vector<Pair>& joined) const {
    const std::uint32_t face = side / 2;
    const glm::vec3* corner = &detail_.corners[3 * std::size_t{face}];
    const glm::vec3 z = side % 2 == 0 ? detail_.normal[face] : -detail_.normal[face];
    const glm::vec3 x = glm::normalize(glm::cross(z, std::abs(z.x) < 0.5F ? glm::vec3(1, 0, 0) : glm::vec3(0, 1, 0)));
    const glm::vec3 y = glm::cross(z, x);
    const glm::vec3 middle = (corner[0] + corner[1] + corner[2]) / 3.0F;
    std::vector<std::uint32_t> others;
    std::uint32_t k = 0;
    for (const glm::vec3& rim : points_of(corner)) {
      const float away = glm::length(middle - rim);
      const glm::vec3 point = rim + (middle - rim) * (away > 3 * kInsetM ? kInsetM / away : 1.0F / 3);
      Packet rays = make_directions(++k);
      for (glm::vec3& ray : rays) ray = x * ray.x + y * ray.y + z * ray.z;
      for (const LightScene::Hit& hit : scene_->closest(point + z * detail_.bias_m, rays, kFarM)) {
        if (!std::isfinite(hit.distance_m)) {
          joined.push_back({side, spaces_.open()});
          return;
        }
        const std::uint32_t other = 2 * hit.triangle + (hit.from_behind ? 1 : 0);
        others.push_back(other);
      }
    }
    std::ranges::sort(others);
    others.erase(std::unique(others.begin(), others.end()), others.end());
    for (const std::uint32_t other : others) joined.push_back({side, other});
  }

  // Rows from the first edge to the corner opposite; the rim is among them.
  [[nodiscard]] std::vector<glm::vec3> points_of(const glm::vec3* corner) const {
    const float longest = std::max(
        {glm::length(corner[1] - corner[0]), glm::length(corner[2] - corner[1]), glm::length(corner[0] - corner[2])});
    const int rows = std::clamp(static_cast<int>(std::ceil(longest / kSpacingM)), 3, row_limit_);
    std::vector<glm::vec3> out;
    for (int i = 0; i <= rows; ++i)
      for (int j = 0; j <= rows - i; ++j) {
        const float b = static_cast<float>(i) / static_cast<float>(rows);
        const float c = static_cast<float>(j) / static_cast<float>(rows);
        out.push_back(corner[0] * (1 - b - c) + corner[1] * b + corner[2] * c);
      }
    return out;
  }

  const LatticeMesh& mesh_;
  unsigned threads_;
  LightDetail detail_;
  const LightScene* scene_ = nullptr;
  int row_limit_ = 0;
  Spaces spaces_;
  std::vector<bool> seen_;  // sides that had their rays
};

}  // namespace

Result<ExteriorScene> drop_interior(SnappedScene&& input, BakeContext& context) {
  context.begin(BakeStage::kExterior);
  ExteriorScene out = {std::move(input), 0};
  SnappedScene& scene = out.scene;
  const LatticeBox box = bounds_of(scene.mesh);
  if (*std::ranges::max_element(box.max) * scene.lattice.step_m() > kWideWorldM) {
    scene.notes.push_back({"faces of a world wider than 65 km, kept whether they can be seen from outside or not",
                           scene.mesh.faces.size()});
    return out;
  }
  ZC_ASSIGN(const std::vector<bool> visible, Exterior(scene.mesh, scene.lattice.step_m(), context.threads()).visible());
  std::vector<LatticeFace> faces;
  std::vector<SceneObject> objects;
  for (SceneObject& object : scene.objects) {
    const auto first = static_cast<std::uint32_t>(faces.size());
    for (std::uint32_t f = object.first_triangle; f < object.first_triangle + object.triangle_count; ++f)
      if (visible[f]) faces.push_back(scene.mesh.faces[f]);
    object.first_triangle = first;
    object.triangle_count = static_cast<std::uint32_t>(faces.size()) - first;
    if (object.triangle_count > 0) objects.push_back(std::move(object));
  }
  out.dropped = scene.mesh.faces.size() - faces.size();
  scene.mesh.faces = std::move(faces);
  scene.objects = std::move(objects);
  if (out.dropped > 0) weld(scene.mesh);
  return out;
}

}  // namespace zc
