// SPDX-License-Identifier: Apache-2.0
// Which earlier triangle of a zone a triangle is most likely lit as: the last one that shares a corner with it and
// faces the same way, else the last one that faces the same way. What a `.zbvh` stores of light is relative to it.
// Borrows the mesh. Threads: one at a time.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdlib>
#include <vector>

#include "streamer/world_format/bvh_page.h"
#include "streamer/world_format/scratch_memory.h"

namespace zc {

class LightOrder {
 public:
  static constexpr std::uint32_t kNone = 0xFFFFFFFFU;

  explicit LightOrder(const ZoneMesh& mesh) : mesh_(mesh) {
    if (is_narrow(mesh.triangles.size()))
      narrow_.resize(kFacings * mesh.vertices.size());
    else
      wide_.resize(kFacings * mesh.vertices.size());
    last_.fill(kNone);
  }
  static std::uint64_t scratch_bytes(std::uint64_t triangles, std::uint64_t vertices) {
    return is_narrow(triangles) ? array_scratch<std::uint16_t>(kFacings * vertices)
                                : array_scratch<std::uint32_t>(kFacings * vertices);
  }

  // Before `add(triangle)`.
  struct Place {
    std::uint32_t facing;
    std::uint32_t neighbour;                 // or kNone
    bool is_near;                            // they share a corner
    std::array<std::uint32_t, 3> at_corner;  // at each corner the last one that faces the same way, or kNone
  };
  [[nodiscard]] Place place(std::uint32_t triangle) const {
    Place at{facing_of(triangle), kNone, false, {}};
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t other = at.at_corner[k] = last_at(kFacings * mesh_.triangles[triangle][k] + at.facing);
      if (other != kNone) at.neighbour = at.is_near ? std::max(at.neighbour, other) : other;
      at.is_near = at.is_near || other != kNone;
    }
    if (!at.is_near) at.neighbour = last_[at.facing];
    return at;
  }
  void add(std::uint32_t triangle, std::uint32_t facing) {
    for (const std::uint32_t v : mesh_.triangles[triangle]) {
      if (wide_.empty())
        narrow_[kFacings * v + facing] = static_cast<std::uint16_t>(triangle + 1);
      else
        wide_[kFacings * v + facing] = triangle + 1;
    }
    last_[facing] = triangle;
  }

  // The sky at a vertex as one of its triangles has it.
  [[nodiscard]] std::uint32_t sky_at(const gpu::TriangleLight& light, std::uint32_t triangle,
                                     std::uint32_t vertex) const {
    const auto& corners = mesh_.triangles[triangle];
    const unsigned k = corners[0] == vertex ? 0 : corners[1] == vertex ? 1 : 2;
    return light.sky >> (8 * k) & 0xFFU;
  }

 private:
  static constexpr std::uint32_t kFacings = 6;

  static bool is_narrow(std::uint64_t triangles) { return triangles < 1U << 16U; }
  [[nodiscard]] std::uint32_t last_at(std::size_t at) const { return (wide_.empty() ? narrow_[at] : wide_[at]) - 1; }

  // The axis that its normal is nearest to, and the sign.
  [[nodiscard]] std::uint32_t facing_of(std::uint32_t triangle) const {
    const auto& corners = mesh_.triangles[triangle];
    std::array<std::array<std::int64_t, 3>, 2> edges{};
    for (std::size_t e = 0; e < 2; ++e)
      for (std::size_t axis = 0; axis < 3; ++axis)
        edges[e][axis] = std::int64_t{mesh_.vertices[corners[e + 1]][axis]} - mesh_.vertices[corners[0]][axis];
    std::uint32_t facing = 0;
    std::int64_t most = -1;
    for (std::uint32_t axis = 0; axis < 3; ++axis) {
      const std::size_t u = (axis + 1) % 3;
      const std::size_t v = (axis + 2) % 3;
      const std::int64_t n = edges[0][u] * edges[1][v] - edges[0][v] * edges[1][u];
      if (std::abs(n) <= most) continue;
      most = std::abs(n);
      facing = 2 * axis + (n < 0 ? 1 : 0);
    }
    return facing;
  }

  const ZoneMesh& mesh_;
  // By vertex and facing: the last triangle plus one. Zones rarely have more than 16 bits of them.
  std::vector<std::uint16_t> narrow_;
  std::vector<std::uint32_t> wide_;
  std::array<std::uint32_t, kFacings> last_;
};

// A triangle's bounced light, field by field.
struct BouncedLight {
  static constexpr std::array<std::uint32_t, 5> kMost = {31, 63, 31, 63, 255};
  std::array<std::uint32_t, 5> levels{};  // red, green, blue, share, variation
  std::uint32_t sun = 0;
  std::array<std::uint32_t, 2> direction{};

  BouncedLight() = default;
  explicit BouncedLight(const gpu::TriangleLight& light)
      : levels({light.bounce & 31U, light.bounce >> 5U & 63U, light.bounce >> 11U & 31U, light.bounce >> 16U & 63U,
                light.sky >> 24U}),
        sun(light.bounce >> 22U & 3U),
        direction({light.bounce >> 24U & 15U, light.bounce >> 28U}) {}
  // Without the sky at the corners.
  [[nodiscard]] gpu::TriangleLight pack() const {
    return {levels[4] << 24U, levels[0] | levels[1] << 5U | levels[2] << 11U | levels[3] << 16U | sun << 22U |
                                  direction[0] << 24U | direction[1] << 28U};
  }
  bool operator==(const BouncedLight&) const = default;
};

}  // namespace zc
