// SPDX-License-Identifier: Apache-2.0
// From a host's frame to what shaders read. Thread-safe: no state.
#pragma once

#include "runtime/device/binding_table.h"
#include "runtime/host_frame.h"
#include "runtime/scene/zone_set.h"
#include "shaders/shared/frame.h"

namespace zc {

// The camera's and the light's part; the rest is left as it is.
void fill_frame_data(const FrameCamera& camera, const FrameSun& sun, std::uint32_t width, std::uint32_t height,
                     gpu::FrameData& out);
// The zones' part.
void fill_frame_data(const ZoneSet& zones, gpu::FrameData& out);

void bind_zones(const ZoneSet& zones, BindingTable& table);

}  // namespace zc
