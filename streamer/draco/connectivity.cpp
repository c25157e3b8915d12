// SPDX-License-Identifier: Apache-2.0
#include "streamer/draco/connectivity.h"

#include <algorithm>

namespace zc {

// Of a vertex: a corner there with no triangle left of it, unless there are triangles all around; with a tag the vertex
// that it has become, or, once vertices are numbered, its value.
std::uint32_t DracoConnectivity::vertex(std::uint32_t c) {
  std::uint32_t v = m_.corners[c];
  while ((m_.vertices[v] & kTag) != 0) {
    const std::uint32_t other = m_.vertices[v] & ~kTag;
    if ((m_.vertices[other] & kTag) != 0) m_.vertices[v] = m_.vertices[other];
    v = other;
  }
  return v;
}

bool DracoConnectivity::add_vertex(std::uint32_t corner) {
  if (vertex_count_ == m_.vertices.size()) return false;
  m_.corners[corner] = vertex_count_;
  m_.vertices[vertex_count_++] = corner;
  return true;
}

bool DracoConnectivity::left_edge(std::uint32_t vertex, std::uint32_t& corner) const {
  corner = next_corner(m_.vertices[vertex]);
  return is_free(corner);
}

// An event says that an edge of one triangle waits for a triangle with a split that comes later. Until the triangles
// are there their places keep it, as the split's triangle plus one: of the left edge in the first, of the right one in
// the second.
bool DracoConnectivity::place_split_events() {
  ByteReader in(layout_.split_symbols);
  DracoBits edges(layout_.split_edges);
  std::uint64_t source = 0;  // counted from the last symbol
  for (std::uint32_t i = 0; i < layout_.split_events; ++i) {
    source += in.varint();
    const std::uint32_t distance = in.varint();
    if (source >= layout_.symbols || distance == 0 || distance > source) return false;
    const std::uint32_t face = layout_.symbols - 1 - static_cast<std::uint32_t>(source);
    std::uint32_t& place = m_.corners[first_corner(face) + edges.read(1)];
    if (place != 0) return false;
    place = face + distance + 1;
  }
  return true;
}

bool DracoConnectivity::read_context_symbols() {
  std::uint32_t at = 0;
  for (std::size_t i = 0; i < layout_.contexts.size(); ++i) {
    const DracoLayout::Context& context = layout_.contexts[i];
    context_begin_[i] = at;
    if (context.count > 0) {
      DracoSymbols symbols;
      if (!symbols.start(context.symbols)) return false;
      for (const std::uint32_t end = at + context.count; at < end; ++at) {
        const std::uint32_t symbol = symbols.read<1>()[0];
        if (symbol > kE) return false;
        m_.symbols[at] = static_cast<std::byte>(symbol);
      }
    }
    context_end_[i] = at;
  }
  return true;
}

bool DracoConnectivity::read_symbol(std::uint32_t face, std::uint32_t& symbol) {
  if (!layout_.by_valence) {
    symbol = symbol_bits_.read(1) == 0 ? 0 : 1 + symbol_bits_.read(2);
  } else if (face == 0) {
    symbol = kE;
  } else {
    if (context_end_[context_] == context_begin_[context_]) return false;
    symbol = std::to_integer<std::uint32_t>(m_.symbols[--context_end_[context_]]);
  }
  return true;
}

bool DracoConnectivity::glue() {
  std::ranges::fill(m_.opposites.words(), kNoCorner);
  if (!place_split_events()) return false;
  symbol_bits_ = DracoBits(layout_.symbol_bits);
  if (layout_.by_valence) {
    std::ranges::fill(m_.valences, std::byte{0});
    if (!read_context_symbols()) return false;
  }
  for (std::uint32_t face = 0; face < layout_.symbols; ++face) {
    std::uint32_t symbol = 0;
    const std::uint32_t corner = first_corner(face);
    const std::array<std::uint32_t, 2> events = {m_.corners[corner], m_.corners[corner + 1]};
    const std::uint32_t split_edge = m_.opposites[corner];
    if (!read_symbol(face, symbol) || !add_triangle(face, symbol, split_edge)) return false;
    active_ = corner;
    if (layout_.by_valence) count_valences(corner, symbol);
    for (std::uint32_t side = 0; side < 2; ++side) {
      if (events[side] == 0) continue;
      // Only the last triangle before a split has an edge that is left alone.
      if (symbol == kC || symbol == kS) return false;
      std::uint32_t& place = m_.opposites[first_corner(events[side] - 1)];
      if (place != kNoCorner) return false;
      place = side == 0 ? corner + 2 : corner + 1;
    }
  }
  return add_start_faces();
}

bool DracoConnectivity::add_triangle(std::uint32_t face, std::uint32_t symbol, std::uint32_t split_edge) {
  const std::uint32_t corner = first_corner(face);
  if (symbol == kS) return add_split(corner, split_edge);
  if (split_edge != kNoCorner) return false;
  if (symbol == kE) return add_alone(corner);
  if (active_ == kNoCorner) return false;
  return symbol == kC ? add_between(corner) : add_beside(corner, symbol == kR);
}

// Symbol C: between the active edge and the free one left of it, whose common vertex is surrounded then.
bool DracoConnectivity::add_between(std::uint32_t corner) {
  const std::uint32_t a = active_;
  const std::uint32_t middle = vertex(next_corner(a));
  std::uint32_t b = 0;
  if (!left_edge(middle, b)) return false;
  const std::uint32_t right = vertex(previous_corner(a));
  push(corner, pop(a));
  join(a, corner + 1);
  join(b, corner + 2);
  m_.corners[corner] = middle;
  m_.corners[corner + 1] = vertex(next_corner(b));
  m_.corners[corner + 2] = right;
  m_.vertices[right] = corner + 2;
  return true;
}

// Symbols L and R: on the active edge, with a new vertex.
bool DracoConnectivity::add_beside(std::uint32_t corner, bool right) {
  const std::uint32_t a = active_;
  const std::uint32_t tip = right ? corner + 2 : corner + 1;
  const std::uint32_t at_right = next_corner(tip);
  const std::uint32_t left_vertex = vertex(next_corner(a));
  const std::uint32_t right_vertex = vertex(previous_corner(a));
  if (!add_vertex(tip)) return false;
  push(corner, pop(a));
  join(a, tip);
  m_.corners[at_right] = right_vertex;
  m_.vertices[right_vertex] = at_right;
  m_.corners[previous_corner(tip)] = left_vertex;
  return true;
}

// Symbol S: between the active edge and the one below it, or the one that an event has left for it. Where both end
// opposite to each other two vertices become one.
bool DracoConnectivity::add_split(std::uint32_t corner, std::uint32_t split_edge) {
  const std::uint32_t b = active_;
  if (b == kNoCorner) return false;
  std::uint32_t below = pop(b);
  std::uint32_t a = split_edge;
  if (a == kNoCorner) {
    a = below;
    if (a == kNoCorner) return false;
    below = pop(a);
  } else if (!is_free(a)) {
    return false;
  }
  const std::uint32_t stays = vertex(previous_corner(a));
  const std::uint32_t goes = vertex(next_corner(b));
  const std::uint32_t right = vertex(previous_corner(b));
  if (stays == goes) return false;
  push(corner, below);
  join(a, corner + 2);
  join(b, corner + 1);
  m_.corners[corner] = stays;
  m_.corners[corner + 1] = vertex(next_corner(a));
  m_.corners[corner + 2] = right;
  m_.vertices[right] = corner + 2;
  m_.vertices[stays] = m_.vertices[goes];
  m_.vertices[goes] = kTag | stays;
  if (layout_.by_valence) add_valence(stays, std::to_integer<std::uint32_t>(m_.valences[goes]));
  return true;
}

// Symbol E: a triangle by itself.
bool DracoConnectivity::add_alone(std::uint32_t corner) {
  for (std::uint32_t k = 0; k < 3; ++k)
    if (!add_vertex(corner + k)) return false;
  push(corner, active_);
  return true;
}

void DracoConnectivity::add_valence(std::uint32_t vertex, std::uint32_t more) {
  std::byte& valence = m_.valences[vertex];
  valence = static_cast<std::byte>(std::min(std::to_integer<std::uint32_t>(valence) + more, 255U));
}

// How many edges each vertex has so far, which the symbol after this one is coded by.
void DracoConnectivity::count_valences(std::uint32_t corner, std::uint32_t symbol) {
  static constexpr std::array<std::array<std::uint32_t, 3>, 5> kMore = {
      {{0, 1, 1}, {0, 1, 1}, {1, 2, 1}, {1, 1, 2}, {2, 2, 2}}};
  for (std::uint32_t k = 0; k < 3; ++k) add_valence(vertex(corner + k), kMore[symbol][k]);
  const auto valence = std::to_integer<std::uint32_t>(m_.valences[vertex(corner + 1)]);
  constexpr std::uint32_t kLeast = 2;
  context_ = std::clamp<std::uint32_t>(valence, kLeast, kLeast + DracoLayout::kContexts - 1) - kLeast;
}

// What is left of each part is open at its edge, or one triangle closes it.
bool DracoConnectivity::add_start_faces() {
  RansBits bits;
  if (!bits.start(layout_.start_faces)) return false;
  std::uint32_t face = layout_.symbols;
  while (active_ != kNoCorner) {
    const std::uint32_t below = pop(active_);
    if (!bits.read()) {
      m_.opposites[active_] = kNoCorner;
    } else if (face == layout_.faces || !add_start_face(first_corner(face++))) {
      return false;
    }
    active_ = below;
  }
  return face == layout_.faces;
}

bool DracoConnectivity::add_start_face(std::uint32_t corner) {
  const std::uint32_t a = active_;
  std::uint32_t b = 0;
  std::uint32_t c = 0;
  const std::uint32_t n = vertex(next_corner(a));
  if (!left_edge(n, b)) return false;
  const std::uint32_t x = vertex(next_corner(b));
  if (!left_edge(x, c) || c == b) return false;
  m_.corners[corner] = x;
  m_.corners[corner + 1] = vertex(next_corner(c));
  m_.corners[corner + 2] = n;
  join(a, corner);
  join(b, corner + 1);
  join(c, corner + 2);
  return true;
}

bool DracoConnectivity::visit_vertex(std::uint32_t corner, std::span<std::uint32_t> corner_of_value) {
  std::uint32_t& v = m_.vertices[m_.corners[corner] & ~kTag];
  if ((v & kTag) != 0) return true;
  if (value_count_ == corner_of_value.size()) return false;
  corner_of_value[value_count_] = corner;
  v = kTag | value_count_++;
  return true;
}

bool DracoConnectivity::number(std::span<std::uint32_t> corner_of_value) {
  for (std::uint32_t t = 0; t < layout_.faces; ++t)
    for (std::uint32_t k = 0; k < 3; ++k) m_.corners[first_corner(t) + k] = vertex(first_corner(t) + k);
  value_count_ = 0;
  for (std::uint32_t t = 0; t < layout_.faces; ++t)
    if (!is_visited(first_corner(t)) && !traverse_from(first_corner(t), corner_of_value)) return false;
  for (std::uint32_t t = 0; t < layout_.faces; ++t)
    for (std::uint32_t k = 0; k < 3; ++k) {
      std::uint32_t& corner = m_.corners[first_corner(t) + k];
      const std::uint32_t value = m_.vertices[corner & ~kTag];
      if ((value & kTag) == 0) return false;
      corner = value & ~kTag;
    }
  return value_count_ == corner_of_value.size();
}

// Depth first, to the right as long as it goes.
bool DracoConnectivity::traverse_from(std::uint32_t c, std::span<std::uint32_t> corner_of_value) {
  if (!visit_vertex(next_corner(c), corner_of_value) || !visit_vertex(previous_corner(c), corner_of_value))
    return false;
  // Corners of triangles to the left that have been left for later; the edge across leads to the one below.
  std::uint32_t waiting = kNoCorner;
  while (true) {
    m_.corners[first_corner_beside(c)] |= kTag;
    const std::uint32_t v = m_.vertices[m_.corners[c] & ~kTag];
    const std::uint32_t right = m_.opposites[next_corner(c)];
    if ((v & kTag) == 0) {
      if (!visit_vertex(c, corner_of_value)) return false;
      if (!is_free(next_corner(v))) {
        if (right == kNoCorner) return false;
        c = right;
        continue;
      }
    }
    const std::uint32_t edge = previous_corner(c);
    const std::uint32_t left = m_.opposites[edge];
    const bool goes_right = right != kNoCorner && !is_visited(right);
    const bool goes_left = left != kNoCorner && !is_visited(left);
    if (goes_right) {
      if (goes_left) {
        push(edge, waiting);
        waiting = left;
      }
      c = right;
    } else if (goes_left) {
      c = left;
    } else {
      c = kNoCorner;
      while (waiting != kNoCorner && c == kNoCorner) {
        const std::uint32_t across = m_.opposites[waiting];
        if (!is_visited(waiting)) c = waiting;
        const std::uint32_t below = pop(across);
        join(across, waiting);
        waiting = below;
      }
      if (c == kNoCorner) return true;
    }
  }
}

}  // namespace zc
