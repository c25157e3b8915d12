// SPDX-License-Identifier: Apache-2.0
// The entropy coding of Draco streams: bits, and symbols of any alphabet, by range asymmetric numeral systems. Symbols
// are found by their place among the cumulative frequencies, in a table with an entry for each symbol that occurs;
// frequencies add up to as much as 2^20, and a table of that size is what this does without.
// Sources: Duda 2013, "Asymmetric numeral systems"; Draco bitstream 2.2, "Rans Decoding", "Rans Bit Decoder", "Symbol
// Decoding"; tagged symbols, which those leave out, as draco 1.5.5 codes them (symbol_decoding.h).
// Borrows the stream. Untrusted input: after the end come zeros. Threads: one at a time.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "streamer/draco/byte_reader.h"

namespace zc {

// Bits as they lie in bytes, the lowest first.
class DracoBits {
 public:
  explicit DracoBits(std::span<const std::byte> data = {}) : data_(data) {}

  std::uint32_t read(unsigned count) {  // at most 32
    while (held_ < count) {
      if (at_ < data_.size()) bits_ |= static_cast<std::uint64_t>(data_[at_++]) << held_;
      held_ += 8;
    }
    const auto value = static_cast<std::uint32_t>(bits_ & ((std::uint64_t{1} << count) - 1));
    bits_ >>= count;
    held_ -= count;
    return value;
  }

 private:
  std::span<const std::byte> data_;
  std::size_t at_ = 0;
  std::uint64_t bits_ = 0;
  unsigned held_ = 0;
};

// The number that is read, and the bytes behind it from the last to the first.
class RansState {
 public:
  // Fails when the last bytes are no state of this base.
  bool start(std::span<const std::byte> data, std::uint32_t base, unsigned size_bytes_most) {
    if (data.empty()) return false;
    const unsigned size = (static_cast<unsigned>(data.back()) >> 6U) + 1;
    if (size > size_bytes_most || size > data.size()) return false;
    base_ = base;
    at_ = data.data() + (data.size() - size);
    begin_ = data.data();
    value = 0;
    for (unsigned i = size; i-- > 0;) value = value << 8U | static_cast<std::uint32_t>(at_[i]);
    value = (value & ((1U << (8 * size - 2)) - 1)) + base;
    return value < base * 256;
  }
  void refill() {
    while (value < base_ && at_ != begin_) value = value << 8U | static_cast<std::uint32_t>(*--at_);
  }

  std::uint32_t value = 0;

 private:
  std::uint32_t base_ = 0;
  const std::byte* at_ = nullptr;
  const std::byte* begin_ = nullptr;
};

// Bits of one probability.
class RansBits {
 public:
  struct Block {
    std::uint8_t zero = 0;  // probability, in 256ths
    std::span<const std::byte> data;
  };
  static Block skip(ByteReader& in) {
    const std::uint8_t zero = in.byte();
    return {zero, in.bytes(in.varint())};
  }

  bool start(const Block& block) {
    one_ = static_cast<std::uint8_t>(256U - block.zero);
    return state_.start(block.data, kBase, 3);
  }
  bool read() {
    state_.refill();
    const std::uint32_t ones = (state_.value >> 8U) * one_;
    const std::uint32_t place = state_.value & 0xFFU;
    const bool bit = place < one_;
    state_.value = bit ? ones + place : state_.value - ones - one_;
    return bit;
  }

 private:
  static constexpr std::uint32_t kBase = 4096;
  RansState state_;
  std::uint32_t one_ = 0;
};

// Symbols of one alphabet, or as many bits each as a symbol before says.
class DracoSymbols {
 public:
  static constexpr std::uint32_t kSmall = 33;  // alphabets up to this need no memory
  // An entry of a table: the sum of the frequencies of the symbols before, and the symbol.
  static constexpr std::uint32_t kEntryWords = 2;

  struct Block {
    bool tagged = false;
    unsigned precision_bits = 0;
    std::uint32_t alphabet = 0;
    std::uint32_t used = 0;  // symbols that occur
    std::span<const std::byte> frequencies;
    std::span<const std::byte> data;
    std::span<const std::byte> bits;  // of tagged ones

    [[nodiscard]] std::uint64_t table_words() const {
      return used <= kSmall ? 0 : kEntryWords * (std::uint64_t{used} + 1);
    }
  };
  // `count` symbols, in groups that share a tag. Takes no memory.
  static Block skip(ByteReader& in, std::uint64_t count, unsigned group);

  // `table` has room for block.table_words(). False for a damaged block.
  bool start(const Block& block, std::span<std::uint32_t> table = {});
  template <std::size_t kGroup>
  std::array<std::uint32_t, kGroup> read() {
    std::array<std::uint32_t, kGroup> out{};
    if (tagged_) {
      const std::uint32_t size = next();
      for (std::uint32_t& value : out) value = bits_.read(size);
    } else {
      for (std::uint32_t& value : out) value = next();
    }
    return out;
  }

 private:
  static void skip_raw(ByteReader& in, unsigned bits, Block& block);
  std::uint32_t next() {
    state_.refill();
    const std::uint32_t place = state_.value & ((1U << precision_bits_) - 1);
    const std::uint32_t* at = table_.data() + first_[place >> bucket_shift_];
    while (at[kEntryWords] <= place) at += kEntryWords;
    state_.value = (state_.value >> precision_bits_) * (at[kEntryWords] - at[0]) + place - at[0];
    return at[1];
  }

  static constexpr unsigned kBucketBits = 9;
  bool tagged_ = false;
  unsigned precision_bits_ = 0;
  unsigned bucket_shift_ = 0;
  RansState state_;
  DracoBits bits_;
  std::span<std::uint32_t> table_;
  std::array<std::uint32_t, kEntryWords*(kSmall + 1)> small_{};
  // By the leading bits of a place: where the entry begins that it is in.
  std::array<std::uint32_t, 1U << kBucketBits> first_{};
};

}  // namespace zc
