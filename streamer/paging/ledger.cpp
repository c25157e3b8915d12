// SPDX-License-Identifier: Apache-2.0
#include "streamer/paging/ledger.h"

#include <algorithm>
#include <utility>

#include "base/check.h"

namespace zc {

const char* ledger_class_name(LedgerClass ledger_class) {
  static constexpr std::array<const char*, kLedgerClassCount> kNames = {"index",     "state",   "top_level", "pool",
                                                                        "in_flight", "decoded", "scratch"};
  return kNames[static_cast<std::size_t>(ledger_class)];
}

Reservation::Reservation(Reservation&& other) noexcept
    : ledger_(std::exchange(other.ledger_, nullptr)), class_(other.class_), bytes_(std::exchange(other.bytes_, 0)) {}

Reservation& Reservation::operator=(Reservation&& other) noexcept {
  if (this != &other) {
    release();
    ledger_ = std::exchange(other.ledger_, nullptr);
    class_ = other.class_;
    bytes_ = std::exchange(other.bytes_, 0);
  }
  return *this;
}

void Reservation::release() {
  if (ledger_ != nullptr) ledger_->give_back(class_, bytes_);
  ledger_ = nullptr;
  bytes_ = 0;
}

Ledger::~Ledger() { ZC_CHECK(total_.current_bytes == 0); }

std::optional<Reservation> Ledger::try_reserve(LedgerClass ledger_class, std::uint64_t bytes) {
  const std::lock_guard lock(mutex_);
  if (bytes > cap_bytes_ - total_.current_bytes) return std::nullopt;
  LedgerUse& one = classes_[static_cast<std::size_t>(ledger_class)];
  for (LedgerUse* account : {&one, &total_}) {
    account->current_bytes += bytes;
    account->peak_bytes = std::max(account->peak_bytes, account->current_bytes);
  }
  return Reservation(*this, ledger_class, bytes);
}

LedgerUse Ledger::total() const {
  const std::lock_guard lock(mutex_);
  return total_;
}

LedgerUse Ledger::use(LedgerClass ledger_class) const {
  const std::lock_guard lock(mutex_);
  return classes_[static_cast<std::size_t>(ledger_class)];
}

void Ledger::give_back(LedgerClass ledger_class, std::uint64_t bytes) {
  const std::lock_guard lock(mutex_);
  LedgerUse& one = classes_[static_cast<std::size_t>(ledger_class)];
  ZC_CHECK(bytes <= one.current_bytes && bytes <= total_.current_bytes);
  one.current_bytes -= bytes;
  total_.current_bytes -= bytes;
}

}  // namespace zc
