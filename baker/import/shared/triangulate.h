// SPDX-License-Identifier: GPL-3.0-or-later
// Constrained Delaunay triangulation of rings in the plane; the only place that includes CGAL's 2D triangulations.
// Thread-safe: no state.
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec2.hpp>
#include <span>
#include <vector>

namespace zc {

// One past each ring's last point is in `ring_ends`. Appends anticlockwise triangles of indices into `points` that
// cover what an odd number of rings enclose. False, and nothing appended, when rings cross where no point is.
bool triangulate_rings(std::span<const glm::dvec2> points, std::span<const std::uint32_t> ring_ends,
                       std::vector<std::array<std::uint32_t, 3>>& out);

// Likewise, triangles of all that lies between the rings' corners: each within every ring or outside of it.
bool triangulate_between(std::span<const glm::dvec2> points, std::span<const std::uint32_t> ring_ends,
                         std::vector<std::array<std::uint32_t, 3>>& out);

}  // namespace zc
