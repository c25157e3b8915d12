// SPDX-License-Identifier: Apache-2.0
#include "streamer/draco/layout.h"

#include <algorithm>
#include <cstring>

namespace zc {
namespace {

constexpr std::uint32_t kFacesMost = 1U << 28U;  // corners leave bits for tags
constexpr unsigned kAttributesMost = 4;
constexpr std::uint8_t kUint16 = 4;
constexpr std::uint8_t kNoPrediction = 0xFE;
constexpr std::uint8_t kWrap = 1;

void read_edgebreaker(ByteReader& in, DracoLayout& out) {
  const std::uint8_t traversal = in.byte();
  if (traversal != 0 && traversal != 2) in.fail();
  out.by_valence = traversal == 2;
  out.values = in.varint();
  out.faces = in.varint();
  const std::uint8_t seams = in.byte();  // attributes with a connectivity of their own
  out.symbols = in.varint();
  const std::uint32_t splits = in.varint();
  if (out.faces == 0 || out.faces > kFacesMost || out.symbols > out.faces || splits > out.symbols ||
      out.values > 3 * out.faces - splits)
    in.fail();
  if (in.failed()) return;
  out.vertices = out.values + splits;

  out.split_events = in.varint();
  if (out.split_events > out.symbols) in.fail();
  const std::span<const std::byte> from = in.rest();
  for (std::uint32_t s = 0; s < 2 * std::uint64_t{out.split_events} && !in.failed(); ++s) in.varint();
  out.split_symbols = from.first(from.size() - in.rest().size());
  out.split_edges = in.bytes((std::uint64_t{out.split_events} + 7) / 8);
  if (!out.by_valence) out.symbol_bits = in.bytes(in.varint());
  out.start_faces = RansBits::skip(in);
  for (unsigned i = 0; i < seams && !in.failed(); ++i) RansBits::skip(in);
  if (!out.by_valence) return;
  for (DracoLayout::Context& context : out.contexts) {
    context.count = in.varint();
    if (context.count > out.symbols) in.fail();
    if (context.count > 0 && !in.failed()) context.symbols = DracoSymbols::skip(in, context.count, 1);
    if (context.symbols.table_words() > 0) in.fail();  // there are five kinds of triangles
  }
  if (out.context_symbols() > out.symbols) in.fail();
}

void read_sequential(ByteReader& in, DracoLayout& out) {
  out.faces = in.varint();
  out.values = in.varint();
  // With more, indices have 32 bits.
  if (out.faces == 0 || out.faces > kFacesMost || out.values > 3 * out.faces || out.values >= 1U << 21U) in.fail();
  if (in.failed()) return;
  const std::uint64_t corners = 3 * std::uint64_t{out.faces};
  out.coded_indices = in.byte() == 0;
  if (out.coded_indices) {
    out.index_symbols = DracoSymbols::skip(in, corners, 1);
    return;
  }
  const std::span<const std::byte> from = in.rest();
  if (out.values >= 1U << 16U)
    for (std::uint64_t i = 0; i < corners && !in.failed(); ++i) in.varint();
  else
    in.bytes((out.values < 256 ? 1 : 2) * corners);
  out.plain_indices = from.first(from.size() - in.rest().size());
}

// How many attributes there are, in the order of their values, and which of them has the positions.
unsigned read_attributes(ByteReader& in, bool edgebreaker, std::uint32_t position_id,
                         std::array<bool, kAttributesMost>& is_position) {
  const unsigned decoders = in.byte();
  if (decoders == 0 || decoders > kAttributesMost) in.fail();
  std::array<bool, kAttributesMost> by_vertex{};  // in the order of the connectivity's own vertices
  for (unsigned d = 0; d < decoders && edgebreaker && !in.failed(); ++d) {
    const std::uint8_t data = in.byte();
    const std::uint8_t kind = in.byte();
    by_vertex[d] = in.byte() == 0 && kind == 0 && data == 0xFF;
  }
  unsigned attributes = 0;
  bool found = false;
  for (unsigned d = 0; d < decoders && !in.failed(); ++d) {
    const std::uint32_t count = in.varint();
    if (count == 0 || count > kAttributesMost - attributes) in.fail();
    for (std::uint32_t a = 0; a < count && !in.failed(); ++a) {
      in.byte();  // what for
      const std::uint8_t type = in.byte();
      const std::uint8_t components = in.byte();
      in.byte();  // normalised
      is_position[attributes + a] = in.varint() == position_id && !found;
      if (!is_position[attributes + a]) continue;
      found = true;
      if (type != kUint16 || components != 3 || (edgebreaker && !by_vertex[d])) in.fail();
    }
    for (std::uint32_t a = 0; a < count && !in.failed(); ++a)
      if (in.byte() != 1) in.fail();  // integers
    attributes += count;
  }
  if (!found) in.fail();
  return attributes;
}

// One attribute's values. `values` is 0 where nobody knows how many there are.
void read_values(ByteReader& in, std::uint64_t values, DracoLayout& out) {
  using Prediction = DracoLayout::Prediction;
  const std::uint8_t method = in.byte();
  switch (method) {
    case kNoPrediction:
      out.prediction = Prediction::kNone;
      break;
    case 0:
      out.prediction = Prediction::kDifference;
      break;
    case 1:
      out.prediction = Prediction::kParallelogram;
      break;
    case 4:
      out.prediction = Prediction::kParallelograms;
      break;
    default:
      in.fail();
  }
  if (method != kNoPrediction && in.byte() != kWrap) in.fail();
  if (in.byte() == 0) in.fail();  // plain integers
  out.corrections = DracoSymbols::skip(in, 3 * values, 3);
  if (values == 0 && out.corrections.tagged) in.fail();  // no length
  out.creases = {};
  if (out.prediction == Prediction::kParallelograms)
    for (DracoLayout::Creases& creases : out.creases) {
      creases.count = in.varint();
      if (creases.count > 0) creases.bits = RansBits::skip(in);
    }
  if (method == kNoPrediction) return;
  out.min = in.int32();
  out.max = in.int32();
}

}  // namespace

std::uint64_t DracoLayout::context_symbols() const {
  std::uint64_t sum = 0;
  for (const Context& context : contexts) sum += context.count;
  return sum;
}

namespace {

// Opposites | the values' corners, or before that valences and symbols | vertices, or after that a table.
std::uint64_t edgebreaker_words(std::uint64_t faces, std::uint64_t values, std::uint64_t vertices,
                                std::uint64_t symbols, std::uint64_t table_words) {
  return 3 * faces + std::max(values, (vertices + 3) / 4 + (symbols + 3) / 4) + std::max(vertices, table_words);
}

}  // namespace

std::uint64_t DracoLayout::scratch_words() const {
  if (!edgebreaker) return std::max(corrections.table_words(), index_symbols.table_words());
  return edgebreaker_words(faces, values, vertices, context_symbols(), corrections.table_words());
}

std::uint64_t draco_scratch_words_most(std::uint64_t faces, std::uint64_t values, std::uint64_t stream_bytes) {
  // Each symbol that occurs takes a byte of the stream, and comes once at least in what is decoded.
  const std::uint64_t entries = std::min(std::max(3 * values, 3 * faces), stream_bytes) + 1;
  return edgebreaker_words(faces, values, 3 * faces, faces, DracoSymbols::kEntryWords * entries);
}

const char* read_draco_layout(std::span<const std::byte> stream, std::uint32_t position_id, DracoLayout& layout) {
  constexpr std::size_t kHeaderBytes = 11;
  const auto byte = [&](std::size_t i) { return static_cast<std::uint32_t>(stream[i]); };
  if (stream.size() < kHeaderBytes || std::memcmp(stream.data(), "DRACO", 5) != 0) return "not a Draco stream";
  if (byte(5) != 2 || byte(6) != 2) return "Draco bitstream is not version 2.2";
  if (byte(7) != 1 || byte(8) > 1) return "Draco stream is not a mesh";
  if (byte(9) != 0 || byte(10) != 0) return "Draco stream has metadata";
  constexpr const char* kFault = "Draco stream is damaged or of a kind that zones do not have";
  layout = {};
  layout.edgebreaker = byte(8) == 1;
  ByteReader in(stream.subspan(kHeaderBytes));
  if (layout.edgebreaker)
    read_edgebreaker(in, layout);
  else
    read_sequential(in, layout);
  std::array<bool, kAttributesMost> is_position{};
  const unsigned count = in.failed() ? 0 : read_attributes(in, layout.edgebreaker, position_id, is_position);
  for (unsigned a = 0; a < count && !in.failed(); ++a) {
    read_values(in, is_position[a] || !layout.edgebreaker ? layout.values : 0, layout);
    if (is_position[a]) break;
  }
  if (in.failed() || layout.values == 0) return kFault;
  if (layout.prediction == DracoLayout::Prediction::kNone) return nullptr;
  if (!layout.edgebreaker && layout.prediction != DracoLayout::Prediction::kDifference) return kFault;
  return layout.min < 0 || layout.max > UINT16_MAX || layout.min > layout.max ? kFault : nullptr;
}

}  // namespace zc
