// SPDX-License-Identifier: Apache-2.0
// A sample of a path as the renderer takes it. Thread-safe: no state.
#pragma once

#include "base/result.h"
#include "replay/paths/camera_path.h"
#include "runtime/host_frame.h"
#include "streamer/world_format/index_view.h"

namespace zc {

// The camera relative to the lattice point next to its eye, so that floats near it are exact. Fails where the
// renderer's 32-bit lattice does not reach.
Result<FrameCamera> make_camera(const IndexView& index, const CameraSample& sample);

}  // namespace zc
