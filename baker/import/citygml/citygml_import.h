// SPDX-License-Identifier: GPL-3.0-or-later
// CityGML 1.0, 2.0 and 3.0 into the scene: every feature at its highest level of detail up to LoD3, with semantics,
// materials and textures. Rooms, LoD4 and empty spaces are left out. Source: OGC 12-019; OGC 20-010 and 21-006r2.
// Geographic reference systems get a local frame, z up. Untrusted input.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "baker/import/shared/input_files.h"
#include "baker/import/shared/scene_builder.h"
#include "baker/import/shared/texture_images.h"

namespace zc {

// The name of a document's root without its prefix, as far as `begin` shows it; empty where it does not.
std::string root_of_xml(std::string_view begin);

// files: that images are read from.
Status import_citygml(std::vector<std::byte> bytes, const std::string& path, const InputFiles& files,
                      TextureImages& images, SceneBuilder& builder);

}  // namespace zc
