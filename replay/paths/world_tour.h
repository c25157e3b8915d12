// SPDX-License-Identifier: Apache-2.0
// Where a world lies, whether a camera looks at it, and a flight over it for whoever has no path.
// Units: the world's CRS, metres. Thread-safe: no state.
#pragma once

#include <glm/vec3.hpp>
#include <string>

#include "replay/paths/camera_path.h"
#include "streamer/source/source.h"
#include "streamer/world_format/index_view.h"

namespace zc {

struct Bounds {
  glm::dvec3 min, max;
};
Bounds world_bounds(const IndexView& index);
std::string describe_bounds(const IndexView& index);  // "x 4.0 to 9.5, y … m"

// Once round the place where the coarsest proxies have the most triangles, from where nearly all of them are in view,
// or 1.5 km, down to its roofs: 20 s, 30 cameras a second. Fails as reading the root's page does.
Result<CameraPath> tour_of(Source& source, const IndexView& index);

// Whether a zone lies in the view, and the world is not too far away to be seen. Fails as make_camera().
Result<bool> looks_at_world(const IndexView& index, const CameraSample& sample, double aspect);
// Of a path none of whose cameras does; `first`: its first one.
Error nothing_seen(const IndexView& index, const CameraSample& first);

}  // namespace zc
