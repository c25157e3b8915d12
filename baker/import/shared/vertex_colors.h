// SPDX-License-Identifier: GPL-3.0-or-later
// Colours of corners as colours of triangles, in steps where there are many: each is a material, and a scene has
// 65,535. Thread-safe: no state.
#pragma once

#include <glm/vec3.hpp>
#include <span>

namespace zc {

// sRGB, brought to 0 to 1 (no number: 0), and to 32 steps where more than 4,096 colours differ.
void limit_colors(std::span<glm::vec3> srgb);

// Linear: the corners' colour where it is one, else their mean in steps. The colours are limited ones.
glm::vec3 triangle_color(const glm::vec3& a, const glm::vec3& b, const glm::vec3& c);

}  // namespace zc
