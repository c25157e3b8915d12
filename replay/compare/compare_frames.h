// SPDX-License-Identifier: Apache-2.0
// From where `compare` looks. Thread-safe: no state.
#pragma once

#include <string>
#include <vector>

#include "base/result.h"
#include "replay/compare/compare.h"
#include "replay/paths/camera_path.h"
#include "streamer/world_format/index_view.h"

namespace zc {

struct CompareFrame {
  std::string name;  // of its pictures
  CameraSample camera;
  bool sees_world = false;
};

// Fails where none of them looks at the world, or none lies on the path.
Result<std::vector<CompareFrame>> choose_frames(Source& source, const IndexView& index, const CompareOptions& options);

}  // namespace zc
