// SPDX-License-Identifier: GPL-3.0-or-later
// Contents of 3D Tiles into the scene, told apart by their first bytes: b3dm, cmpt, GLB, glTF. i3dm and pnts are
// counted in the notes. Source: OGC 22-025r4 (3D Tiles 1.1), sections 10 and 12. Untrusted input.
#pragma once

#include "baker/import/gltf/gltf_import.h"

namespace zc {

// Fails when lengths disagree with the file, on headers from before 1.0 and on any other kind of content.
Status import_tile_content(const std::filesystem::path& file, const GltfPlace& place, TextureImages& images,
                           SceneBuilder& builder);

}  // namespace zc
