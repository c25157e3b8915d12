// SPDX-License-Identifier: Apache-2.0
#include "replay/session/cap_search.h"

#include <gtest/gtest.h>

#include <array>
#include <set>

namespace zc {
namespace {

constexpr std::array kFractions = {0.5, 0.9, 1.0};

TEST(CapSearch, WhatItFindsDoesAndAThirtySecondLessDoesNot) {
  std::set<std::uint64_t> measured;
  const auto truth = [](std::uint64_t cap) {
    return static_cast<double>(std::min<std::uint64_t>(cap, 7'000'000)) / 7e6;
  };
  const auto needs = find_caps(kFractions, 100'000, 50'000'000, [&](std::uint64_t cap) -> Result<double> {
    EXPECT_TRUE(measured.insert(cap).second) << "measured twice";
    return truth(cap);
  });
  ASSERT_TRUE(needs.ok());
  ASSERT_EQ(needs->size(), kFractions.size());
  for (std::size_t i = 0; i < kFractions.size(); ++i) {
    const CapNeed& need = (*needs)[i];
    ASSERT_TRUE(need.cap_bytes.has_value());
    EXPECT_EQ(need.fraction, kFractions[i]);
    EXPECT_GE(truth(*need.cap_bytes), kFractions[i]);
    EXPECT_EQ(need.reached, truth(*need.cap_bytes));
    EXPECT_LT(truth(*need.cap_bytes - *need.cap_bytes / 32 - 4096), kFractions[i]);
  }
  EXPECT_LT(measured.size(), 30U);
  EXPECT_LE(*measured.rbegin(), 12'800'000U) << "no further up than the first that does";
}

TEST(CapSearch, TheSmallestCapMayDoAndNoneMayDo) {
  const auto all = find_caps(kFractions, 1000, 50'000, [](std::uint64_t) -> Result<double> { return 1.0; });
  ASSERT_TRUE(all.ok());
  for (const CapNeed& need : *all) EXPECT_EQ(need.cap_bytes, 1000U);
  const auto some = find_caps(kFractions, 1000, 50'000, [](std::uint64_t) -> Result<double> { return 0.6; });
  ASSERT_TRUE(some.ok());
  EXPECT_EQ((*some)[0].cap_bytes, 1000U);
  EXPECT_FALSE((*some)[1].cap_bytes.has_value());
  EXPECT_EQ((*some)[2].reached, 0.6);
}

TEST(CapSearch, AFailureEndsIt) {
  const auto needs = find_caps(kFractions, 1000, 50'000, [](std::uint64_t cap) -> Result<double> {
    if (cap > 1000) return Error{ErrorCode::kIo, "gone"};
    return 0.0;
  });
  ASSERT_FALSE(needs.ok());
  EXPECT_EQ(needs.error().message, "gone");
}

}  // namespace
}  // namespace zc
