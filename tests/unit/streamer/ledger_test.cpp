// SPDX-License-Identifier: Apache-2.0
#include "streamer/paging/ledger.h"

#include <gtest/gtest.h>

#include <atomic>
#include <thread>
#include <vector>

namespace zc {
namespace {

TEST(Ledger, refuses_the_byte_above_the_cap_and_takes_the_one_at_it) {
  Ledger ledger(100);
  const auto pool = ledger.try_reserve(LedgerClass::kPool, 60);
  ASSERT_TRUE(pool);
  EXPECT_FALSE(ledger.try_reserve(LedgerClass::kScratch, 41));
  EXPECT_FALSE(ledger.try_reserve(LedgerClass::kScratch, UINT64_MAX));
  EXPECT_TRUE(ledger.try_reserve(LedgerClass::kScratch, 40));
  EXPECT_EQ(ledger.total().current_bytes, 60U);
  EXPECT_EQ(ledger.total().peak_bytes, 100U);
  EXPECT_EQ(ledger.use(LedgerClass::kScratch).current_bytes, 0U);
  EXPECT_EQ(ledger.use(LedgerClass::kScratch).peak_bytes, 40U);
}

TEST(Ledger, a_moved_reservation_gives_its_bytes_back_once) {
  Ledger ledger(10);
  auto first = ledger.try_reserve(LedgerClass::kIndex, 4);
  Reservation second = std::move(*first);
  first.reset();
  EXPECT_EQ(ledger.total().current_bytes, 4U);
  second = Reservation();
  EXPECT_EQ(ledger.total().current_bytes, 0U);
  second.release();
}

TEST(Ledger, holds_the_cap_against_many_threads) {
  Ledger ledger(1000);
  std::atomic<int> taken{0};
  {
    std::vector<std::jthread> threads;
    for (int t = 0; t < 4; ++t)
      threads.emplace_back([&] {
        for (int i = 0; i < 2000; ++i)
          if (ledger.try_reserve(LedgerClass::kInFlight, static_cast<std::uint64_t>(100 + i % 400))) ++taken;
      });
  }
  EXPECT_GT(taken, 0);
  EXPECT_LE(ledger.total().peak_bytes, 1000U);
  EXPECT_EQ(ledger.total().current_bytes, 0U);
}

TEST(LedgerDeathTest, checks_that_nothing_is_left) {
  EXPECT_DEATH(
      {
        Reservation kept;
        {
          Ledger ledger(10);
          kept = std::move(*ledger.try_reserve(LedgerClass::kPool, 1));
        }
      },
      "broken invariant");
}

}  // namespace
}  // namespace zc
