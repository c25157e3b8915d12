// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/repair/stitch.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numeric>
#include <optional>
#include <vector>

#include "baker/distance/lattice_distance.h"
#include "baker/repair/face_edges.h"

namespace zc {
namespace {

bool touches(const LatticePoint& a, const LatticePoint& b) {
  for (std::size_t axis = 0; axis < 3; ++axis)
    if (std::abs(std::int64_t{a[axis]} - b[axis]) > 1) return false;
  return true;
}

class Stitcher {
 public:
  explicit Stitcher(const LatticeMesh& mesh)
      : mesh_(mesh),
        open_(open_edges(mesh)),
        at_vertex_(open_, mesh.vertices.size()),
        target_(mesh.vertices.size()),
        is_target_(mesh.vertices.size(), false),
        matched_(open_.size(), false) {
    std::iota(target_.begin(), target_.end(), 0U);
  }

  StitchCounts run() {
    for (std::uint32_t e = 0; e < open_.size(); ++e) {
      if (matched_[e]) continue;
      const auto partner = find_partner(e);
      if (!partner) continue;
      matched_[e] = true;
      matched_[*partner] = true;
      ++counts_.joined;
    }
    return counts_;
  }
  [[nodiscard]] std::uint32_t target(std::uint32_t vertex) const { return target_[vertex]; }

 private:
  // Open vertices within a step; vertices are sorted.
  void find_near(std::uint32_t vertex, std::vector<std::uint32_t>& near) const {
    near.clear();
    const LatticePoint& p = mesh_.vertices[vertex];
    for (std::int32_t dx = -1; dx <= 1; ++dx) {
      for (std::int32_t dy = -1; dy <= 1; ++dy) {
        auto at = std::lower_bound(mesh_.vertices.begin(), mesh_.vertices.end(),
                                   LatticePoint{p[0] + dx, p[1] + dy, p[2] - 1});
        for (; at != mesh_.vertices.end() && touches(*at, p) && (*at)[0] == p[0] + dx && (*at)[1] == p[1] + dy; ++at) {
          const auto v = static_cast<std::uint32_t>(at - mesh_.vertices.begin());
          if (!at_vertex_.at(v).empty()) near.push_back(v);
        }
      }
    }
  }

  // Where two vertices would join: a vertex moves once, and never from under one that moved to it.
  struct Move {
    std::uint32_t from, to;
  };
  [[nodiscard]] std::optional<Move> join(std::uint32_t a, std::uint32_t b) const {
    const std::uint32_t at = target_[a];
    const std::uint32_t bt = target_[b];
    if (at == bt) return Move{at, at};
    const auto can_move = [&](std::uint32_t v, std::uint32_t to) {
      return target_[v] == v && !is_target_[v] && touches(mesh_.vertices[v], mesh_.vertices[to]);
    };
    if (b > a && can_move(b, at)) return Move{b, at};
    if (can_move(a, bt)) return Move{a, bt};
    if (can_move(b, at)) return Move{b, at};
    return std::nullopt;
  }

  static bool clash(const Move& a, const Move& b) {
    if (a.from == a.to || b.from == b.to) return false;
    return a.from == b.from || a.from == b.to || a.to == b.from;
  }

  void apply(const Move& move) {
    if (move.from == move.to) return;
    target_[move.from] = move.to;
    is_target_[move.to] = true;
    const LatticeVector d = difference(mesh_.vertices[move.to], mesh_.vertices[move.from]);
    counts_.moved = std::max(counts_.moved, std::sqrt(static_cast<double>(dot(d, d))));
  }

  // An edge that may lie on this one, and its ends beside this one's.
  struct Candidate {
    std::uint32_t low, edge, high;
    auto operator<=>(const Candidate&) const = default;
  };

  // By way of the end of fewer edges: at the hub of a fan all of them do.
  void find_candidates(const FaceEdge& edge) {
    find_near(edge.low, near_low_);
    find_near(edge.high, near_high_);
    const auto edges_at = [&](const std::vector<std::uint32_t>& near) {
      std::size_t count = 0;
      for (const std::uint32_t v : near) count += at_vertex_.at(v).size();
      return count;
    };
    const bool by_high = edges_at(near_high_) < edges_at(near_low_);
    const LatticePoint& far = mesh_.vertices[by_high ? edge.low : edge.high];
    candidates_.clear();
    for (const std::uint32_t here : by_high ? near_high_ : near_low_) {
      for (const std::uint32_t e : at_vertex_.at(here)) {
        const std::uint32_t there = open_[e].low == here ? open_[e].high : open_[e].low;
        if (!touches(mesh_.vertices[there], far)) continue;
        candidates_.push_back(by_high ? Candidate{there, e, here} : Candidate{here, e, there});
      }
    }
    std::ranges::sort(candidates_);
  }

  std::optional<std::uint32_t> find_partner(std::uint32_t e) {
    const FaceEdge& edge = open_[e];
    find_candidates(edge);
    for (const auto& [low, other, high] : candidates_) {
      const FaceEdge& candidate = open_[other];
      if (other == e || matched_[other] || candidate.face == edge.face) continue;
      // A corner of one face must not end on another of its own.
      if (high == edge.low || low == edge.high || has_corner(edge.face, low, edge.low) ||
          has_corner(edge.face, high, edge.high) || has_corner(candidate.face, edge.low, low) ||
          has_corner(candidate.face, edge.high, high))
        continue;
      const auto first = join(edge.low, low);
      const auto second = join(edge.high, high);
      if (!first || !second || clash(*first, *second)) continue;
      apply(*first);
      apply(*second);
      return other;
    }
    return std::nullopt;
  }

  [[nodiscard]] bool has_corner(std::uint32_t face, std::uint32_t vertex, std::uint32_t except) const {
    return vertex != except && std::ranges::find(mesh_.faces[face].v, vertex) != mesh_.faces[face].v.end();
  }

  const LatticeMesh& mesh_;
  std::vector<FaceEdge> open_;
  EdgesAtVertex at_vertex_;
  std::vector<std::uint32_t> target_;
  std::vector<bool> is_target_;
  std::vector<bool> matched_;  // per open edge
  std::vector<std::uint32_t> near_low_, near_high_;
  std::vector<Candidate> candidates_;
  StitchCounts counts_;
};

}  // namespace

StitchCounts stitch_open_edges(MeshPart& part) {
  Stitcher stitcher(part.mesh);
  const StitchCounts counts = stitcher.run();
  if (counts.joined == 0) return counts;
  for (LatticeFace& face : part.mesh.faces)
    for (std::uint32_t& v : face.v) v = stitcher.target(v);
  weld(part.mesh);
  return counts;
}

}  // namespace zc
