// SPDX-License-Identifier: Apache-2.0
// Edgebreaker: the triangles of a Draco mesh stream, each glued to those before it as one of five symbols says; then
// the order in which their vertices have their values.
//
// Across the edge that corner c (corners.h) faces lies the corner opposites[c]. That array stores all lists too, so
// that none takes memory: a free edge that waits to be glued stores the one that waits below it, and so does an edge of
// the traversal with an unvisited triangle behind it. A triangle's places store what waits for it before it is there.
// Vertices that a split joins refer to the one that stays, as the sets of a union-find do.
//
// Sources: Rossignac 1999, "Edgebreaker"; Isenburg & Snoeyink 2001, "Spirale Reversi" (symbols from the last to the
// first); Draco bitstream 2.2, "EdgeBreaker Decoder", "EdgeBreaker Traversal", "EdgeBreaker Traversal Valence Decoder",
// "EdgeBreaker Traverser"; Tarjan 1975 (union-find).
// Borrows everything. Untrusted input: a stream is refused as soon as it would glue an edge twice. Threads: one at a
// time.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "streamer/draco/corners.h"
#include "streamer/draco/layout.h"

namespace zc {

class DracoConnectivity {
 public:
  // By corner, by vertex, and for streams by valence by vertex and by symbol.
  struct Memory {
    VertexOfCorner corners;  // zeroed
    WordOfCorner opposites;
    std::span<std::uint32_t> vertices;
    std::span<std::byte> valences;
    std::span<std::byte> symbols;
  };
  DracoConnectivity(const DracoLayout& layout, const Memory& memory) : layout_(layout), m_(memory) {}

  // Glues the triangles. False for a damaged stream.
  bool glue();
  // After glue(): turns the vertices of `corners` into the numbers of their values, and gives for each value the corner
  // that reaches it first. False when there are not as many values as the stream says.
  bool number(std::span<std::uint32_t> corner_of_value);

 private:
  enum Symbol : std::uint8_t { kC, kS, kL, kR, kE };
  static constexpr std::uint32_t kTag = 1U << 31U;
  static constexpr std::uint32_t kBottom = kTag | 0x7FFFFFFEU;  // of a list

  bool place_split_events();
  bool read_context_symbols();
  bool read_symbol(std::uint32_t face, std::uint32_t& symbol);
  bool add_triangle(std::uint32_t face, std::uint32_t symbol, std::uint32_t split_edge);
  bool add_between(std::uint32_t corner);
  bool add_beside(std::uint32_t corner, bool right);
  bool add_split(std::uint32_t corner, std::uint32_t split_edge);
  bool add_alone(std::uint32_t corner);
  bool add_start_faces();
  bool add_start_face(std::uint32_t corner);
  void add_valence(std::uint32_t vertex, std::uint32_t more);
  void count_valences(std::uint32_t corner, std::uint32_t symbol);
  bool traverse_from(std::uint32_t corner, std::span<std::uint32_t> corner_of_value);
  bool visit_vertex(std::uint32_t corner, std::span<std::uint32_t> corner_of_value);

  [[nodiscard]] bool is_free(std::uint32_t c) const { return m_.opposites[c] == kNoCorner; }
  void join(std::uint32_t a, std::uint32_t b) {
    m_.opposites[a] = b;
    m_.opposites[b] = a;
  }
  [[nodiscard]] std::uint32_t pop(std::uint32_t c) const {
    return m_.opposites[c] == kBottom ? kNoCorner : m_.opposites[c] & ~kTag;
  }
  void push(std::uint32_t c, std::uint32_t below) { m_.opposites[c] = below == kNoCorner ? kBottom : kTag | below; }
  std::uint32_t vertex(std::uint32_t c);
  bool add_vertex(std::uint32_t corner);
  // The free edge at the left of the triangles around a vertex.
  bool left_edge(std::uint32_t vertex, std::uint32_t& corner) const;
  [[nodiscard]] bool is_visited(std::uint32_t c) const { return (m_.corners[first_corner_beside(c)] & kTag) != 0; }

  const DracoLayout& layout_;
  Memory m_;
  DracoBits symbol_bits_;
  std::array<std::uint32_t, DracoLayout::kContexts> context_begin_{};
  std::array<std::uint32_t, DracoLayout::kContexts> context_end_{};  // symbols come from there
  std::uint32_t context_ = 0;
  std::uint32_t vertex_count_ = 0;
  std::uint32_t active_ = kNoCorner;  // the free edge that the next triangle is glued to; others wait below it
  std::uint32_t value_count_ = 0;
};

}  // namespace zc
