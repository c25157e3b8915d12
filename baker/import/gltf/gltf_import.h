// SPDX-License-Identifier: GPL-3.0-or-later
// glTF 2.0 and GLB into the scene: one object per node with a mesh, transforms in double precision, y up turned to z
// up. Untrusted input.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <glm/mat4x4.hpp>
#include <string>
#include <vector>

#include "baker/import/shared/input_files.h"
#include "baker/import/shared/scene_builder.h"
#include "baker/import/shared/texture_images.h"
#include "baker/import/shared/up_axis.h"
#include "base/result.h"

namespace zc {

// Where a model stands and lies.
struct GltfPlace {
  glm::dmat4 to_world{1};                   // once z is up
  UpAxis up = UpAxis::kY;                   // of the model
  std::filesystem::path root;               // its buffers and images may not lie outside
  const InputFiles* files = &disk_files();  // that these are read from
  std::int64_t byte_offset = 0;             // of the model in its file
};

Status import_gltf(std::vector<std::byte> bytes, const std::string& path, const GltfPlace& place, TextureImages& images,
                   SceneBuilder& builder);

}  // namespace zc
