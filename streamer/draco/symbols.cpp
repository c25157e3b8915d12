// SPDX-License-Identifier: Apache-2.0
#include "streamer/draco/symbols.h"

#include <algorithm>

namespace zc {
namespace {

constexpr unsigned kMaxBits = 18;  // of a raw symbol
constexpr unsigned kTagBits = 5;

// A frequency has its length in the lowest two bits of its first byte, or there a 3 and above it how many more symbols
// do not occur.
struct Frequency {
  std::uint32_t value = 0;
  std::uint32_t zeros_more = 0;
};
Frequency read_frequency(ByteReader& in) {
  const std::uint8_t first = in.byte();
  if ((first & 3U) == 3U) return {0, std::uint32_t{first} >> 2U};
  std::uint32_t value = std::uint32_t{first} >> 2U;
  for (unsigned i = 0; i < (first & 3U); ++i) value |= std::uint32_t{in.byte()} << (6 + 8 * i);
  return {value, 0};
}

}  // namespace

void DracoSymbols::skip_raw(ByteReader& in, unsigned bits, Block& block) {
  block.precision_bits = std::clamp(3 * bits / 2, 12U, 20U);
  block.alphabet = in.varint();
  const std::span<const std::byte> from = in.rest();
  std::uint64_t sum = 0;
  for (std::uint64_t s = 0; s < block.alphabet && !in.failed(); ++s) {
    const Frequency frequency = read_frequency(in);
    sum += frequency.value;
    s += frequency.zeros_more;
    if (s >= block.alphabet) in.fail();
    block.used += frequency.value > 0 ? 1 : 0;
  }
  if (sum != std::uint64_t{1} << block.precision_bits) in.fail();
  block.frequencies = from.first(from.size() - in.rest().size());
  block.data = in.bytes(in.varint());
}

DracoSymbols::Block DracoSymbols::skip(ByteReader& in, std::uint64_t count, unsigned group) {
  Block block;
  const std::uint8_t scheme = in.byte();
  block.tagged = scheme == 0;
  const unsigned bits = block.tagged ? kTagBits : in.byte();
  if (scheme > 1 || bits == 0 || bits > kMaxBits) in.fail();
  skip_raw(in, bits, block);
  if (!block.tagged || in.failed()) return block;
  // Only the tags say how many bits follow.
  DracoSymbols tags;
  if (block.alphabet > kSmall || !tags.start(block)) in.fail();
  std::uint64_t length = 0;
  for (std::uint64_t i = 0; i < count && !in.failed(); i += group) {
    length += std::uint64_t{group} * tags.next();
    if (length > 8 * in.rest().size()) in.fail();
  }
  block.bits = in.bytes((length + 7) / 8);
  return block;
}

bool DracoSymbols::start(const Block& block, std::span<std::uint32_t> table) {
  tagged_ = block.tagged;
  precision_bits_ = block.precision_bits;
  bucket_shift_ = precision_bits_ - kBucketBits;
  bits_ = DracoBits(block.bits);
  table_ = block.table_words() > 0 ? table : std::span<std::uint32_t>(small_);
  ByteReader in(block.frequencies);
  std::uint32_t at = 0;
  std::uint32_t below = 0;
  std::uint32_t bucket = 0;
  for (std::uint32_t s = 0; s < block.alphabet; ++s) {
    const Frequency frequency = read_frequency(in);
    s += frequency.zeros_more;
    if (frequency.value == 0) continue;
    table_[at] = below;
    table_[at + 1] = s;
    below += frequency.value;
    for (; bucket << bucket_shift_ < below; ++bucket) first_[bucket] = at;
    at += kEntryWords;
  }
  table_[at] = below;  // the end of the last one
  table_[at + 1] = 0;
  return state_.start(block.data, 4U << precision_bits_, 4);
}

}  // namespace zc
