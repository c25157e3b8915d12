// SPDX-License-Identifier: Apache-2.0
#include "runtime/tracing/trace_variant.h"

#include <gtest/gtest.h>

#include <array>
#include <map>
#include <set>

namespace zc {
namespace {

constexpr TraceLimits kRoomy{8, 1U << 16U, 24};

std::string choose(const TraceLimits& limits, const std::map<std::string, double>& times_ms,
                   std::vector<std::string>* measured = nullptr) {
  const auto chosen = choose_trace_variant(limits, [&](std::span<const TraceVariant> variants) {
    std::vector<double> of_these;
    for (const TraceVariant& variant : variants) {
      const std::string name = trace_variant_name(variant);
      const auto known = times_ms.find(name);
      of_these.push_back(known == times_ms.end() ? 10 : known->second);
      if (measured != nullptr) measured->push_back(name);
      EXPECT_EQ(unsupported_reason(variant, limits), "");
    }
    return Result<std::vector<double>>(of_these);
  });
  EXPECT_TRUE(chosen.ok());
  return trace_variant_name(*chosen);
}

TEST(TraceVariant, NamesAreOneToOne) {
  const std::vector<TraceVariant> all = all_trace_variants();
  std::set<std::string> names;
  for (const TraceVariant& variant : all) {
    const std::string name = trace_variant_name(variant);
    names.insert(name);
    const auto parsed = parse_trace_variant(name);
    ASSERT_TRUE(parsed.has_value()) << name;
    EXPECT_EQ(*parsed, variant) << name;
  }
  EXPECT_EQ(names.size(), all.size());
  EXPECT_EQ(all.front(), TraceVariant{});
  EXPECT_EQ(trace_variant_name({}), "packets64+texels");
  EXPECT_EQ(trace_variant_name({0, gpu::kPoolStorage, true, 128}), "single+storage+shared+w128");
}

TEST(TraceVariant, OtherNamesAreUnknown) {
  for (const char* name : {"", "auto", "packets64", "packets65+texels", "packets64+texels+w64", "texels+packets64",
                           "packets64+texels ", "Packets64+texels", "single+texels+w32+shared"})
    EXPECT_FALSE(parse_trace_variant(name).has_value()) << name;
}

TEST(TraceVariant, WhatDoesNotFitGivesWayToTheNearestThatDoes) {
  for (const TraceVariant& variant : all_trace_variants()) {
    for (const TraceLimits limits :
         {TraceLimits{0, 0, 24}, TraceLimits{4, 1U << 14U, 24}, TraceLimits{8, 0, 1}, TraceLimits{32, 1U << 16U, 24}}) {
      const TraceVariant near = nearest_fit(variant, limits);
      EXPECT_EQ(unsupported_reason(near, limits), "");
      EXPECT_EQ(unsupported_reason(variant, limits).empty(), near == variant);
      EXPECT_EQ(near.pool_path, variant.pool_path);
      EXPECT_EQ(near.width, variant.width);
    }
  }
  const TraceVariant packets{8, gpu::kPoolTexels, false, 64};
  EXPECT_NE(unsupported_reason(packets, {7, 1U << 16U, 1}), "");
  EXPECT_EQ(unsupported_reason(packets, {8, 0, 100}), "");  // their own stack lies in registers
}

TEST(TraceVariant, SharedStacksTakeEightBytesAnEntryOfEveryInvocation) {
  const TraceVariant shared{0, gpu::kPoolTexels, true, 64};
  EXPECT_EQ(unsupported_reason(shared, {8, 24 * 64 * 8, 24}), "");
  EXPECT_NE(unsupported_reason(shared, {8, 24 * 64 * 8 - 1, 24}), "");
}

TEST(TraceVariant, PoolsThatTexelsDoNotReachAreReadThroughStorage) {
  TraceLimits limits = kRoomy;
  limits.texels = false;
  for (const TraceVariant& variant : all_trace_variants()) {
    EXPECT_EQ(unsupported_reason(variant, limits).empty(), variant.pool_path == gpu::kPoolStorage);
    EXPECT_EQ(nearest_fit(variant, limits).pool_path, gpu::kPoolStorage);
  }
  EXPECT_EQ(choose(limits, {{"single+texels", 1}, {"packets64+texels", 1}}), "packets64+storage");
}

TEST(TraceVariant, TheFastestOfEachStepIsChosen) {
  EXPECT_EQ(choose(kRoomy, {{"single+storage", 5}, {"single+storage+shared", 4}, {"single+storage+shared+w32", 3}}),
            "single+storage+shared+w32");
  EXPECT_EQ(choose(kRoomy, {{"single+storage", 9}, {"packets64+storage", 8}, {"packets32+storage", 7}}),
            "packets32+storage");
  EXPECT_EQ(choose(kRoomy, {{"packets64+texels+w128", 9}}), "packets64+texels+w128");
}

TEST(TraceVariant, TiesGoToTheFirst) {
  EXPECT_EQ(choose(kRoomy, {}), "packets64+texels");
  EXPECT_EQ(choose(kRoomy, {{"single+storage", 9.8}, {"single+texels", 9.71}, {"packets32+texels", 9.75}}),
            "packets64+texels");
  EXPECT_EQ(choose(kRoomy, {{"single+storage", 9.6}}), "single+storage");
}

TEST(TraceVariant, OnlyWhatFitsIsMeasuredAndAlwaysInTheSameOrder) {
  std::vector<std::string> measured;
  choose({0, 0, 24}, {}, &measured);
  EXPECT_EQ(measured, (std::vector<std::string>{"single+texels", "single+storage", "single+texels", "single+texels+w32",
                                                "single+texels+w128"}));
  measured.clear();
  choose(kRoomy, {}, &measured);
  EXPECT_EQ(measured, (std::vector<std::string>{"packets64+texels", "single+texels", "single+storage",
                                                "packets64+texels", "packets32+texels", "packets64+texels",
                                                "packets64+texels+w32", "packets64+texels+w128"}));
}

TEST(TraceVariant, WhenTimeIsUpTheBestSoFarStands) {
  for (int steps = 0; steps < 3; ++steps) {
    int calls = 0;
    const auto chosen =
        choose_trace_variant(kRoomy, [&](std::span<const TraceVariant> variants) -> Result<std::vector<double>> {
          if (calls++ >= steps) return std::vector<double>();
          std::vector<double> falling(variants.size());
          for (std::size_t i = 0; i < falling.size(); ++i) falling[i] = static_cast<double>(falling.size() - i);
          return falling;
        });
    ASSERT_TRUE(chosen.ok());
    const std::array<const char*, 3> expected = {"packets64+texels", "single+storage", "packets64+storage"};
    EXPECT_EQ(trace_variant_name(*chosen), expected[static_cast<std::size_t>(steps)]);
  }
}

TEST(TraceVariant, AFailureToMeasureIsOneToChoose) {
  const auto chosen = choose_trace_variant(kRoomy, [](std::span<const TraceVariant>) -> Result<std::vector<double>> {
    return Error{ErrorCode::kDevice, "lost"};
  });
  ASSERT_FALSE(chosen.ok());
  EXPECT_EQ(chosen.error().message, "lost");
}

}  // namespace
}  // namespace zc
