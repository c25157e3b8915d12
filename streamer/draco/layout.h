// SPDX-License-Identifier: Apache-2.0
// Where the parts of a Draco mesh stream lie and what it takes to decode its positions, by the stream alone and
// without memory: what comes before them (colours) is only skipped, what comes behind is not looked at.
// Borrows the stream. Untrusted input. Thread-safe: pure.
// Source: Draco bitstream 2.2, "Draco Decoder", "EdgeBreaker Decoder", "Sequential Decoder", "Attributes Decoder",
// "Sequential Integer Attribute Decoder", "Prediction Decoder"; where that is behind the format, draco 1.5.5.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "streamer/draco/symbols.h"

namespace zc {

struct DracoLayout {
  bool edgebreaker = false;
  std::uint32_t faces = 0;
  std::uint32_t values = 0;  // positions
  // Edgebreaker.
  std::uint32_t symbols = 0;
  std::uint32_t vertices = 0;  // on the way; those that splits join are one in the end
  std::uint32_t split_events = 0;
  std::span<const std::byte> split_symbols;
  std::span<const std::byte> split_edges;
  bool by_valence = false;
  std::span<const std::byte> symbol_bits;
  RansBits::Block start_faces;
  struct Context {
    std::uint32_t count = 0;
    DracoSymbols::Block symbols;
  };
  static constexpr std::size_t kContexts = 6;
  std::array<Context, kContexts> contexts;
  // Sequential.
  bool coded_indices = false;
  DracoSymbols::Block index_symbols;
  std::span<const std::byte> plain_indices;
  // Positions: 16 bits, three of them.
  enum class Prediction : std::uint8_t { kNone, kDifference, kParallelogram, kParallelograms };
  Prediction prediction = Prediction::kNone;
  DracoSymbols::Block corrections;
  struct Creases {
    std::uint32_t count = 0;
    RansBits::Block bits;
  };
  static constexpr std::size_t kParallelogramsMost = 4;
  std::array<Creases, kParallelogramsMost> creases;
  std::int32_t min = 0;
  std::int32_t max = 0;

  // 32-bit words that decode_draco works in.
  [[nodiscard]] std::uint64_t scratch_words() const;
  [[nodiscard]] std::uint64_t context_symbols() const;
};

// Why the stream cannot be followed, or nothing. `position_id`: the unique id of the attribute.
const char* read_draco_layout(std::span<const std::byte> stream, std::uint32_t position_id, DracoLayout& layout);

// scratch_words() of any stream of so many bytes.
std::uint64_t draco_scratch_words_most(std::uint64_t faces, std::uint64_t values, std::uint64_t stream_bytes);

}  // namespace zc
