// SPDX-License-Identifier: Apache-2.0
#include "streamer/world_format/draco_tables.h"

#include <algorithm>

namespace zc {
namespace {

constexpr std::size_t kHeaderBytes = 11;
constexpr unsigned kMaxBits = 18;
constexpr int kValenceContexts = 6;
constexpr int kCreaseContexts = 4;
constexpr unsigned kMaxAttributes = 2;
constexpr std::uint64_t kTaggedTableBytes = (4U << 12U) + 12 * 32;

// Every read after the end fails for good, and says so at the end.
class Scan {
 public:
  explicit Scan(std::span<const std::byte> data) : data_(data) {}

  std::uint8_t byte() {
    if (at_ >= data_.size()) {
      failed_ = true;
      return 0;
    }
    return static_cast<std::uint8_t>(data_[at_++]);
  }
  std::uint64_t varint() {
    std::uint64_t value = 0;
    for (unsigned shift = 0; shift < 63; shift += 7) {
      const std::uint8_t b = byte();
      value |= std::uint64_t{b & 0x7FU} << shift;
      if ((b & 0x80U) == 0) return value;
    }
    failed_ = true;
    return 0;
  }
  void skip(std::uint64_t bytes) {
    if (bytes > data_.size() - std::min(at_, data_.size()))
      failed_ = true;
    else
      at_ += bytes;
  }
  void fail() { failed_ = true; }
  [[nodiscard]] bool failed() const { return failed_; }

 private:
  std::span<const std::byte> data_;
  std::size_t at_ = 0;
  bool failed_ = false;
};

// A raw-coded block's head: its tables' bytes.
std::uint64_t raw_tables(Scan& scan, std::uint64_t& symbols) {
  const unsigned bits = scan.byte();
  symbols = scan.varint();
  if (bits == 0 || bits > kMaxBits || symbols > (1ULL << 32U)) scan.fail();
  return scan.failed() ? 0 : rans_table_bytes(bits, symbols);
}

// Skips a raw-coded block whose length a later part depends on; a tagged one has no length and is not followed.
std::uint64_t skip_symbols(Scan& scan) {
  if (scan.byte() != 1) scan.fail();
  std::uint64_t symbols = 0;
  const std::uint64_t bytes = raw_tables(scan, symbols);
  for (std::uint64_t s = 0; s < symbols && !scan.failed(); ++s) {
    const std::uint8_t entry = scan.byte();
    if ((entry & 3U) == 3U)
      s += entry >> 2U;  // that many more zeros
    else
      scan.skip(entry & 3U);
  }
  scan.skip(scan.varint());
  return bytes;
}

std::uint64_t skip_edgebreaker(Scan& scan) {
  std::uint64_t most = 0;
  const std::uint8_t traversal = scan.byte();
  scan.varint();                           // vertices
  scan.varint();                           // faces
  const std::uint8_t seams = scan.byte();  // attributes with a connectivity of their own
  scan.varint();                           // symbols
  scan.varint();                           // split symbols
  const std::uint64_t splits = scan.varint();
  for (std::uint64_t s = 0; s < splits && !scan.failed(); ++s) {
    scan.varint();
    scan.varint();
  }
  scan.skip((splits + 7) / 8);
  if (traversal == 0)
    scan.skip(scan.varint());  // the symbols, one bit stream
  else if (traversal != 2)
    scan.fail();
  for (unsigned i = 0; i <= seams && !scan.failed(); ++i) {  // start faces, then seams: probability, length, bits
    scan.byte();
    scan.skip(scan.varint());
  }
  if (traversal == 2)
    for (int context = 0; context < kValenceContexts && !scan.failed(); ++context)
      if (scan.varint() > 0) most = std::max(most, skip_symbols(scan));
  return most;
}

// Sequential connectivity: plain indices, or delta-coded symbols.
std::uint64_t skip_sequential(Scan& scan) {
  const std::uint64_t faces = scan.varint();
  const std::uint64_t points = scan.varint();
  if (faces > (1ULL << 32U)) scan.fail();
  if (scan.byte() == 0) return skip_symbols(scan);
  if (points >= (1U << 21U)) {
    scan.skip(12 * faces);
  } else if (points >= (1U << 16U)) {
    for (std::uint64_t i = 0; i < 3 * faces && !scan.failed(); ++i) scan.varint();
  } else {
    scan.skip((points < 256 ? 3 : 6) * faces);
  }
  return 0;
}

// What a prediction scheme keeps behind the values.
void skip_prediction(Scan& scan, std::uint8_t method) {
  constexpr std::uint8_t kDifference = 0;
  constexpr std::uint8_t kParallelogram = 1;
  constexpr std::uint8_t kConstrainedMultiParallelogram = 4;
  if (method == 0xFE) return;  // none
  if (method == kConstrainedMultiParallelogram) {
    for (int context = 0; context < kCreaseContexts && !scan.failed(); ++context)
      if (scan.varint() > 0) {
        scan.byte();
        scan.skip(scan.varint());
      }
  } else if (method != kDifference && method != kParallelogram) {
    scan.fail();
  }
  scan.skip(8);  // bounds of the wrapped values
}

// One attribute's values; the last one's are not skipped.
std::uint64_t scan_values(Scan& scan, bool is_last) {
  const std::uint8_t method = scan.byte();
  if (method != 0xFE && scan.byte() != 1 && !is_last) scan.fail();  // the transform that wraps
  if (scan.byte() == 0) {                                           // plain integers
    if (!is_last) scan.fail();
    return 0;
  }
  if (!is_last) {
    const std::uint64_t bytes = skip_symbols(scan);
    skip_prediction(scan, method);
    return bytes;
  }
  const std::uint8_t scheme = scan.byte();
  std::uint64_t symbols = 0;
  if (scheme == 0) return kTaggedTableBytes;
  if (scheme == 1) return raw_tables(scan, symbols);
  scan.fail();
  return 0;
}

}  // namespace

std::uint64_t rans_table_bytes(unsigned bits, std::uint64_t symbols) {
  return (4ULL << std::clamp(3 * bits / 2, 12U, 20U)) + 12 * symbols;
}

std::optional<std::uint64_t> draco_table_bytes(std::span<const std::byte> stream) {
  if (stream.size() < kHeaderBytes) return std::nullopt;
  const bool edgebreaker = stream[8] == std::byte{1};
  Scan scan(stream.subspan(kHeaderBytes));
  std::uint64_t most = edgebreaker ? skip_edgebreaker(scan) : skip_sequential(scan);

  const unsigned decoders = scan.byte();
  if (decoders == 0 || decoders > kMaxAttributes) scan.fail();
  if (edgebreaker) scan.skip(3 * decoders);  // attribute data, decoder and traversal
  unsigned attributes = 0;
  for (unsigned d = 0; d < decoders && !scan.failed(); ++d) {
    const std::uint64_t count = scan.varint();
    attributes += static_cast<unsigned>(std::min<std::uint64_t>(count, kMaxAttributes + 1));
    if (count == 0 || attributes > kMaxAttributes) scan.fail();
    for (std::uint64_t a = 0; a < count && !scan.failed(); ++a) {
      scan.skip(4);   // kind, type, components, normalised
      scan.varint();  // unique id
    }
    for (std::uint64_t a = 0; a < count && !scan.failed(); ++a)
      if (scan.byte() != 1) scan.fail();  // integers
  }
  for (unsigned a = 0; a < attributes && !scan.failed(); ++a)
    most = std::max(most, scan_values(scan, a + 1 == attributes));
  if (scan.failed()) return std::nullopt;
  return most;
}

}  // namespace zc
