// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/distance/triangle_pieces.h"

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <queue>
#include <tuple>

namespace zc {
namespace {

struct WastesLess {  // a queue's top wastes the most
  bool operator()(const TrianglePiece& a, const TrianglePiece& b) const {
    if (a.waste != b.waste) return a.waste < b.waste;
    if (a.triangle != b.triangle) return a.triangle < b.triangle;
    return std::tie(a.box.min, a.box.max) < std::tie(b.box.min, b.box.max);
  }
};

}  // namespace

TrianglePiece::TrianglePiece(const Corners& corners, std::uint32_t of) : corner(corners), triangle(of) {
  const auto add = [&](const glm::dvec3& p) {
    box.add(
        LatticePoint{static_cast<std::int32_t>(p.x), static_cast<std::int32_t>(p.y), static_cast<std::int32_t>(p.z)});
  };
  for (const glm::dvec3& p : corner) {
    add(glm::floor(p));
    add(glm::ceil(p));
  }
  const glm::dvec3 n = glm::abs(glm::cross(corner[1] - corner[0], corner[2] - corner[0]));
  waste = half_surface(box) - (n.x + n.y + n.z);
}

double half_surface(const LatticeBox& box) {
  const auto side = [&](std::size_t axis) { return static_cast<double>(std::int64_t{box.max[axis]} - box.min[axis]); };
  return side(0) * side(1) + side(1) * side(2) + side(2) * side(0);
}

std::vector<TrianglePiece> pieces_of(std::size_t count, const std::function<Corners(std::size_t)>& triangle,
                                     double bearable, std::size_t limit) {
  std::vector<TrianglePiece> pieces;
  std::priority_queue<TrianglePiece, std::vector<TrianglePiece>, WastesLess> wasteful;
  for (std::size_t i = 0; i < count; ++i) {
    const TrianglePiece piece(triangle(i), static_cast<std::uint32_t>(i));
    if (piece.waste > bearable) {
      wasteful.push(piece);
    } else {
      pieces.push_back(piece);
    }
  }
  while (!wasteful.empty()) {
    const TrianglePiece piece = wasteful.top();
    wasteful.pop();
    if (piece.waste <= bearable || pieces.size() + wasteful.size() >= limit) {
      pieces.push_back(piece);
      continue;
    }
    std::size_t longest = 0;
    double length = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      const double side = glm::distance(piece.corner[k], piece.corner[(k + 1) % 3]);
      if (side > length) {
        longest = k;
        length = side;
      }
    }
    const glm::dvec3 middle = (piece.corner[longest] + piece.corner[(longest + 1) % 3]) * 0.5;
    for (const std::size_t moved : {longest, (longest + 1) % 3}) {
      auto half = piece.corner;
      half[moved] = middle;
      wasteful.emplace(half, piece.triangle);
    }
  }
  return pieces;
}

}  // namespace zc
