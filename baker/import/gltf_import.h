// SPDX-License-Identifier: GPL-3.0-or-later
// glTF 2.0 and GLB into the scene: one object per node with a mesh, node transforms in double precision, y up turned to
// z up. Untrusted input.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "baker/import/mean_color.h"
#include "baker/import/scene_builder.h"
#include "base/result.h"

namespace zc {

Status import_gltf(std::vector<std::byte> bytes, const std::string& path, MeanColors& images, SceneBuilder& builder);

}  // namespace zc
