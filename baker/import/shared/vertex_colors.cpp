// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/import/shared/vertex_colors.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>

#include "baker/scene/texture_image.h"

namespace zc {
namespace {

constexpr std::size_t kExactColors = 4096;
constexpr float kSteps = 31;

float stepped(float value) { return std::round(value * kSteps) / kSteps; }

glm::vec3 linear(const glm::vec3& srgb) {
  return {srgb_to_linear(srgb.x), srgb_to_linear(srgb.y), srgb_to_linear(srgb.z)};
}

}  // namespace

void limit_colors(std::span<glm::vec3> srgb) {
  std::set<std::array<float, 3>> distinct;
  for (glm::vec3& color : srgb) {
    for (int c = 0; c < 3; ++c) color[c] = color[c] > 0 ? std::min(color[c], 1.0F) : 0.0F;
    if (distinct.size() <= kExactColors) distinct.insert({color.x, color.y, color.z});
  }
  if (distinct.size() <= kExactColors) return;
  for (glm::vec3& color : srgb)
    for (int c = 0; c < 3; ++c) color[c] = stepped(color[c]);
}

glm::vec3 triangle_color(const glm::vec3& a, const glm::vec3& b, const glm::vec3& c) {
  if (a == b && b == c) return linear(a);
  const glm::vec3 mean = (linear(a) + linear(b) + linear(c)) / 3.0F;
  glm::vec3 srgb;
  for (int i = 0; i < 3; ++i) srgb[i] = stepped(static_cast<float>(linear_to_srgb8(mean[i])) / 255);
  return linear(srgb);
}

}  // namespace zc
