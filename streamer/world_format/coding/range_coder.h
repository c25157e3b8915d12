// SPDX-License-Identifier: Apache-2.0
// An adaptive binary range coder, and models of symbols and numbers on top of it. Encoder and Decoder have the same
// interface, so that one function, with the coder as a template parameter, writes a format and reads it.
// Sources: Martin 1979, "Range encoding: an algorithm for removing redundancy from a digitised message"; the carry as
// in LZMA (Pavlov); two rates of adaption mixed as in AV1 and lpaq. Untrusted input: a decoder past the end reads zeros
// and reports so afterwards; a symbol is always in its range. Threads: one at a time.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace zc {

// How likely the next bit is 0, in 65536ths: at first the share of zeros so far, then a mean of two that forget at
// different rates.
class Bit {
 public:
  [[nodiscard]] std::uint32_t zero() const { return (std::uint32_t{fast_} + slow_) / 2; }
  void learn(std::uint32_t bit) {
    const std::int32_t to = bit == 0 ? kMost : kLeast;
    const Rate rate = kRates[seen_];
    fast_ = static_cast<std::uint16_t>(fast_ + (((to - fast_) * rate.fast) >> kRateBits));
    slow_ = static_cast<std::uint16_t>(slow_ + (((to - slow_) * rate.slow) >> kRateBits));
    seen_ = static_cast<std::uint16_t>(seen_ + (seen_ + 1U < kRates.size() ? 1 : 0));
  }

 private:
  static constexpr std::int32_t kLeast = 64;
  static constexpr std::int32_t kMost = 65536 - kLeast;
  static constexpr unsigned kRateBits = 15;  // products of 32 bits
  static constexpr std::size_t kFast = 14;
  // By how much of the way to the end the probabilities move after so many bits.
  struct Rate {
    std::int16_t fast;
    std::int16_t slow;
  };
  static constexpr std::array<Rate, 127> kRates = [] {
    std::array<Rate, 127> rates{};
    for (std::size_t n = 0; n < rates.size(); ++n)
      rates[n] = {static_cast<std::int16_t>((2U << kRateBits) / (2 * std::min(n, kFast) + 3)),
                  static_cast<std::int16_t>((2U << kRateBits) / (2 * n + 3))};
    return rates;
  }();

  std::uint16_t fast_ = 0x8000;
  std::uint16_t slow_ = 0x8000;
  std::uint16_t seen_ = 0;  // of a type that may not be part of a coder's state, which can stay in registers then
};

class Encoder {
 public:
  static constexpr bool kEncodes = true;

  void bit(Bit& model, std::uint32_t& value) {
    narrow((range_ >> 16U) * model.zero(), value);
    model.learn(value);
  }
  // The lower `count` bits, all as likely.
  void bits(std::uint32_t& value, unsigned count) {
    for (unsigned i = count; i-- > 0;) narrow(range_ >> 1U, value >> i & 1U);
  }
  std::vector<std::byte> finish() {
    for (int i = 0; i < 5; ++i) shift();
    return std::move(out_);
  }
  // So far, about.
  [[nodiscard]] std::size_t size() const { return out_.size(); }

 private:
  void narrow(std::uint32_t bound, std::uint32_t bit) {
    if (bit == 0) {
      range_ = bound;
    } else {
      low_ += bound;
      range_ -= bound;
    }
    while (range_ < 1U << 24U) {
      shift();
      range_ <<= 8U;
    }
  }
  // Bytes of ones wait for a carry. The first byte would always be 0 and is not written.
  void shift() {
    if (low_ < 0xFF000000U || low_ > 0xFFFFFFFFU) {
      const auto carry = static_cast<std::uint8_t>(low_ >> 32U);
      for (; waiting_ > 0; --waiting_) {
        if (!first_) out_.push_back(std::byte(static_cast<std::uint8_t>(held_ + carry)));
        first_ = false;
        held_ = 0xFF;
      }
      held_ = static_cast<std::uint8_t>(low_ >> 24U);
    }
    ++waiting_;
    low_ = low_ << 8U & 0xFFFFFFFFU;
  }

  std::uint64_t low_ = 0;
  std::uint32_t range_ = 0xFFFFFFFFU;
  std::uint64_t waiting_ = 1;
  std::uint8_t held_ = 0;
  bool first_ = true;
  std::vector<std::byte> out_;
};

class Decoder {
 public:
  static constexpr bool kEncodes = false;

  explicit Decoder(std::span<const std::byte> bytes) : bytes_(bytes) {
    for (int i = 0; i < 4; ++i) next();
  }
  void bit(Bit& model, std::uint32_t& value) {
    value = narrow((range_ >> 16U) * model.zero());
    model.learn(value);
  }
  void bits(std::uint32_t& value, unsigned count) {
    value = 0;
    for (unsigned i = 0; i < count; ++i) value = value << 1U | narrow(range_ >> 1U);
  }
  // Whether what was read is all there is, neither more nor less.
  [[nodiscard]] bool at_end() const { return at_ == bytes_.size(); }

 private:
  void next() {
    code_ = code_ << 8U | (at_ < bytes_.size() ? std::to_integer<std::uint32_t>(bytes_[at_]) : 0U);
    ++at_;
  }
  std::uint32_t narrow(std::uint32_t bound) {
    std::uint32_t bit = 0;
    if (code_ < bound) {
      range_ = bound;
    } else {
      code_ -= bound;
      range_ -= bound;
      bit = 1;
    }
    while (range_ < 1U << 24U) {
      range_ <<= 8U;
      next();
    }
    return bit;
  }

  std::span<const std::byte> bytes_;
  std::size_t at_ = 0;
  std::uint32_t code_ = 0;
  std::uint32_t range_ = 0xFFFFFFFFU;
};

// One of 2^bits symbols.
template <unsigned bits>
class Symbol {
 public:
  template <class Coder>
  void code(Coder& coder, std::uint32_t& symbol) {
    std::uint32_t node = 1;
    for (unsigned i = bits; i-- > 0;) {
      std::uint32_t bit = symbol >> i & 1U;
      coder.bit(nodes_[node], bit);
      node = node << 1U | bit;
    }
    symbol = node - (1U << bits);
  }

 private:
  std::array<Bit, std::size_t{1} << bits> nodes_;
};

// One of 2^bits symbols, mostly 0: quicker than a Symbol.
template <unsigned bits>
class Change {
 public:
  template <class Coder>
  void code(Coder& coder, std::uint32_t& change) {
    std::uint32_t some = change != 0 ? 1 : 0;
    coder.bit(some_, some);
    if (some != 0)
      symbol_.code(coder, change);
    else
      change = 0;
  }

 private:
  Bit some_;
  Symbol<bits> symbol_;
};

// Any number below 2^32 - 1, small ones at less cost: how many bits it has, the first two of them by experience.
class Number {
 public:
  template <class Coder>
  void code(Coder& coder, std::uint32_t& number) {
    std::uint32_t value = number + 1;
    std::uint32_t length = Coder::kEncodes ? static_cast<std::uint32_t>(std::bit_width(value)) - 1 : 0;
    length_.code(coder, length);
    std::uint32_t head = 1;
    std::uint32_t left = length;
    for (; left > 0 && head < 4; --left) {
      std::uint32_t bit = value >> (left - 1) & 1U;
      coder.bit(heads_[4 * length + head], bit);
      head = head << 1U | bit;
    }
    std::uint32_t rest = value & ((1U << left) - 1U);
    coder.bits(rest, left);
    number = (head << left | rest) - 1;
  }

 private:
  Symbol<5> length_;
  std::array<Bit, 4 * 32> heads_;
};

// Numbers around 0.
class SignedNumber {
 public:
  template <class Coder>
  void code(Coder& coder, std::int32_t& number) {
    std::uint32_t folded = static_cast<std::uint32_t>(number) << 1U ^ static_cast<std::uint32_t>(number >> 31);
    number_.code(coder, folded);
    number = static_cast<std::int32_t>(folded >> 1U) ^ -static_cast<std::int32_t>(folded & 1U);
  }

 private:
  Number number_;
};

}  // namespace zc
