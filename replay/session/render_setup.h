// SPDX-License-Identifier: Apache-2.0
// From a world and a path to what a renderer asks for. Thread-safe: no state.
#pragma once

#include <optional>
#include <vector>

#include "replay/image/png_file.h"
#include "replay/session/camera_path.h"
#include "runtime/renderer.h"
#include "runtime/scene/zone_set.h"
#include "streamer/world_format/sun_angles.h"
#include "streamer/world_format/world_index.h"

namespace zc {

// The camera relative to the lattice point next to its eye, so that floats near it are exact. Fails where the
// renderer's 32-bit lattice does not reach.
Result<RenderCamera> make_camera(const WorldIndex& index, const CameraSample& sample);

std::uint32_t deepest_page(const WorldIndex& index);
std::vector<gpu::MaterialEntry> material_entries(const WorldIndex& index);
// The one that is asked for, else the bake's, else 145,38.
void set_sun(RendererOptions& options, const WorldIndex& index, const std::optional<SunAngles>& asked);

// What the renderer must know of the sets that it will draw.
void fit_sets(RendererOptions& options, const ZoneSet& proxies, const ZoneSet& host);

// What the renderer drew last.
Picture picture_of(const Renderer& renderer, const RendererOptions& options);

}  // namespace zc
