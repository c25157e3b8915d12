// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/repair/mesh_part.h"

namespace zc {

void MeshPart::erase_faces(const std::vector<bool>& drop) {
  std::size_t kept = 0;
  for (std::size_t i = 0; i < mesh.faces.size(); ++i) {
    if (drop[i]) continue;
    mesh.faces[kept] = mesh.faces[i];
    object[kept++] = object[i];
  }
  mesh.faces.resize(kept);
  object.resize(kept);
}

}  // namespace zc
