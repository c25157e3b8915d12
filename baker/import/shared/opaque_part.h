// SPDX-License-Identifier: GPL-3.0-or-later
// Surfaces that are transparent in part: a page stores a surface or it does not, so what is transparent is cut off.
// Panes, of which no part is opaque, stay: they reflect. Thread-safe: no state.
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <string>
#include <vector>

#include "baker/import/images/alpha_mask.h"

namespace zc {

class SceneBuilder;

// Triangles of one material. Borrows its lists, which change.
struct SurfacePart {
  std::vector<glm::dvec3>& positions;
  std::vector<std::array<std::uint32_t, 3>>& triangles;
  std::vector<glm::vec2>& texcoords;      // per position, v downwards; empty: none
  std::vector<std::uint16_t>& materials;  // per triangle
};

// What glTF's alphaMode says, or another format in its own words.
struct Coverage {
  const AlphaMask* mask = nullptr;  // of the texture; null: it is opaque
  TextureWrap wrap_u = TextureWrap::kRepeat;
  TextureWrap wrap_v = TextureWrap::kRepeat;
  double factor = 1;  // of alpha
  double cutoff = 0.5;
  bool keeps_panes = true;
};

// `format` is named in the notes.
void keep_opaque(const Coverage& coverage, const std::string& format, const SurfacePart& part, SceneBuilder& builder);

}  // namespace zc
