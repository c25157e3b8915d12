// SPDX-License-Identifier: GPL-3.0-or-later
// Wavefront OBJ with its materials (MTL) into the scene: one object for each o, or for each g where there are not
// several o; polygons are triangulated, vertex colours kept. Untrusted input. Thread-safe: no state.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>

#include "baker/import/shared/input_files.h"
#include "baker/import/shared/scene_builder.h"
#include "baker/import/shared/texture_images.h"
#include "base/result.h"

namespace zc {

// Whether the first lines are those of an OBJ file: it has no other mark.
bool is_obj(std::string_view text);

Status import_obj(std::span<const std::byte> bytes, const std::string& path, const InputFiles& files,
                  TextureImages& images, SceneBuilder& builder);

}  // namespace zc
