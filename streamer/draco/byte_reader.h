// SPDX-License-Identifier: Apache-2.0
// Reads bytes in order. After the end everything is 0, and failed() is true for good.
// Untrusted input. Threads: one at a time.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>

namespace zc {

class ByteReader {
 public:
  explicit ByteReader(std::span<const std::byte> data) : data_(data) {}

  std::uint8_t byte() {
    if (at_ >= data_.size()) {
      failed_ = true;
      return 0;
    }
    return static_cast<std::uint8_t>(data_[at_++]);
  }
  // Seven bits a byte, the lowest first, of 32 bits or fewer.
  std::uint32_t varint() {
    std::uint64_t value = 0;
    for (unsigned shift = 0; shift < 35; shift += 7) {
      const std::uint8_t b = byte();
      value |= std::uint64_t{b & 0x7FU} << shift;
      if ((b & 0x80U) != 0) continue;
      if (value <= UINT32_MAX) return static_cast<std::uint32_t>(value);
      break;
    }
    failed_ = true;
    return 0;
  }
  std::int32_t int32() {
    std::int32_t value = 0;
    const std::span<const std::byte> four = bytes(sizeof value);
    if (!four.empty()) std::memcpy(&value, four.data(), sizeof value);
    return value;
  }
  // Empty where there are not so many.
  std::span<const std::byte> bytes(std::uint64_t count) {
    if (count > data_.size() - at_) {
      failed_ = true;
      return {};
    }
    const std::span<const std::byte> out = data_.subspan(at_, static_cast<std::size_t>(count));
    at_ += static_cast<std::size_t>(count);
    return out;
  }
  [[nodiscard]] std::span<const std::byte> rest() const { return data_.subspan(at_); }
  void fail() { failed_ = true; }
  [[nodiscard]] bool failed() const { return failed_; }

 private:
  std::span<const std::byte> data_;
  std::size_t at_ = 0;
  bool failed_ = false;
};

}  // namespace zc
