// SPDX-License-Identifier: GPL-3.0-or-later
// A PLY file into the scene, as one object: polygons are triangulated; colours of faces, else of vertices; textures
// that comments name. Untrusted input. Thread-safe: no state.
#pragma once

#include <cstddef>
#include <span>
#include <string>

#include "baker/import/shared/input_files.h"
#include "baker/import/shared/scene_builder.h"
#include "baker/import/shared/texture_images.h"
#include "base/result.h"

namespace zc {

Status import_ply(std::span<const std::byte> bytes, const std::string& path, const InputFiles& files,
                  TextureImages& images, SceneBuilder& builder);

}  // namespace zc
