// SPDX-License-Identifier: GPL-3.0-or-later
// The Polygon File Format (PLY), ASCII and binary of both byte orders, as it is in the file: vertices in double
// precision, polygons, colours, texture coordinates. A reader of our own: those of CGAL and OpenMesh take memory for
// as many vertices or corners as a file declares, and have no place of a fault. Untrusted input: counts are checked
// against the bytes that are left. Thread-safe: no state.
#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <span>
#include <string>
#include <vector>

#include "base/result.h"

namespace zc {

struct PlyMesh {
  std::vector<glm::dvec3> positions;
  std::vector<glm::vec3> colors;     // sRGB, per position; empty: none
  std::vector<glm::vec2> texcoords;  // v upwards, likewise
  std::vector<std::uint32_t> corners;
  std::vector<std::uint64_t> face_ends;     // one past each face's last corner
  std::vector<glm::vec3> face_colors;       // sRGB, per face; empty: none
  std::vector<glm::vec2> corner_texcoords;  // v upwards, per corner; empty: none
  std::vector<std::int32_t> face_textures;  // per face, negative where none; empty: the first one
  std::vector<std::string> texture_files;
};

Result<PlyMesh> read_ply(std::span<const std::byte> bytes, const std::string& path);

}  // namespace zc
