// SPDX-License-Identifier: Apache-2.0
// One account of every byte that the system keeps. Bytes are reserved before they are taken, the sum never exceeds the
// cap, and a Reservation returns its bytes when it is destroyed.
// Threads: every method may be called from several threads at once · the ledger outlives its reservations and checks,
// when it is destroyed, that nothing is left.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <mutex>
#include <optional>

namespace zc {

enum class LedgerClass : std::uint8_t {
  kIndex,     // world.zcw as kept in memory
  kState,     // per-node state, statistics, the selection's working memory
  kTopLevel,  // what the sink takes beside the pool: top-level BVH, zone table, what they are built from
  kPool,      // the page pool, in full from opening
  kInFlight,  // compressed bytes, from request to decoded
  kDecoded,   // decoded pages, until they are uploaded
  kScratch,   // what decoding takes, shared by the workers, in full from opening
};
inline constexpr std::size_t kLedgerClassCount = 7;
const char* ledger_class_name(LedgerClass ledger_class);

struct LedgerUse {
  std::uint64_t current_bytes = 0;
  std::uint64_t peak_bytes = 0;
};

class Ledger;

// Bytes reserved in one class of a ledger. Move-only; empty when default-constructed or moved from.
class Reservation {
 public:
  Reservation() = default;
  Reservation(Reservation&& other) noexcept;
  Reservation& operator=(Reservation&& other) noexcept;
  ~Reservation() { release(); }

  void release();
  [[nodiscard]] std::uint64_t bytes() const { return bytes_; }

 private:
  friend class Ledger;
  Reservation(Ledger& ledger, LedgerClass ledger_class, std::uint64_t bytes)
      : ledger_(&ledger), class_(ledger_class), bytes_(bytes) {}

  Ledger* ledger_ = nullptr;
  LedgerClass class_ = LedgerClass::kIndex;
  std::uint64_t bytes_ = 0;
};

class Ledger {
 public:
  explicit Ledger(std::uint64_t cap_bytes) : cap_bytes_(cap_bytes) {}
  Ledger(const Ledger&) = delete;
  Ledger& operator=(const Ledger&) = delete;
  ~Ledger();

  // Nothing when the bytes do not fit under the cap.
  [[nodiscard]] std::optional<Reservation> try_reserve(LedgerClass ledger_class, std::uint64_t bytes);

  [[nodiscard]] std::uint64_t cap_bytes() const { return cap_bytes_; }
  [[nodiscard]] LedgerUse total() const;
  [[nodiscard]] LedgerUse use(LedgerClass ledger_class) const;

 private:
  friend class Reservation;
  void give_back(LedgerClass ledger_class, std::uint64_t bytes);

  const std::uint64_t cap_bytes_;
  mutable std::mutex mutex_;
  LedgerUse total_;
  std::array<LedgerUse, kLedgerClassCount> classes_;
};

}  // namespace zc
