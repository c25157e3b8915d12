// SPDX-License-Identifier: Apache-2.0
#include "replay/session/units.h"

#include <gtest/gtest.h>

namespace zc {
namespace {

TEST(Units, BytesAreReadInBinaryAndDecimalUnits) {
  const std::pair<const char*, std::uint64_t> cases[] = {
      {"0", 0},           {"4096", 4096},         {"1B", 1},      {"3kB", 3000},       {"3KB", 3000},
      {"2MB", 2'000'000}, {"5GB", 5'000'000'000}, {"1KiB", 1024}, {"64MiB", 67108864}, {"1GiB", 1073741824},
      {"1.5KiB", 1536},   {"2 MiB", 2097152},     {"1e3", 1000}};
  for (const auto& [text, bytes] : cases) {
    const auto parsed = parse_bytes(text);
    ASSERT_TRUE(parsed.ok()) << text;
    EXPECT_EQ(*parsed, bytes) << text;
  }
}

TEST(Units, WhatIsNoQuantityIsRefusedByName) {
  for (const char* text : {"", " ", "x", "MiB", "-1", "-1MiB", "nan", "inf", "1e999", "1e300", "64mib", "64 MiBs",
                           "64MiB ", "6 4MiB", "1  MiB", "0x10", "1,5MiB", "+1"}) {
    const auto parsed = parse_bytes(text);
    ASSERT_FALSE(parsed.ok()) << text;
    EXPECT_EQ(parsed.error().code, ErrorCode::kArgument);
    EXPECT_NE(parsed.error().message.find("'" + std::string(text) + "'"), std::string::npos);
  }
}

TEST(Units, SecondsAndBandwidthsNeedTheirUnits) {
  EXPECT_DOUBLE_EQ(parse_seconds("50ms").value(), 0.05);
  EXPECT_DOUBLE_EQ(parse_seconds("1.5s").value(), 1.5);
  EXPECT_DOUBLE_EQ(parse_seconds("10us").value(), 1e-5);
  EXPECT_DOUBLE_EQ(parse_bytes_per_second("20MB/s").value(), 20e6);
  EXPECT_DOUBLE_EQ(parse_bytes_per_second("1.5 GiB/s").value(), 1.5 * 1073741824.0);
  for (const char* text : {"50", "50m", "-50ms", "s", "", "nans", "infs"})
    EXPECT_FALSE(parse_seconds(text).ok()) << text;
  for (const char* text : {"20MB", "0MB/s", "-1MB/s", "/s", "", "20MB/h", "infMB/s"})
    EXPECT_FALSE(parse_bytes_per_second(text).ok()) << text;
}

TEST(Units, FrameRangesAreHalfOpenAndNeverEmpty) {
  const auto two = parse_frames("3:10");
  ASSERT_TRUE(two.ok());
  EXPECT_EQ(two->begin, 3U);
  EXPECT_EQ(two->end, 10U);
  EXPECT_EQ(two->step, 1U);
  const auto three = parse_frames("0:600:5");
  ASSERT_TRUE(three.ok());
  EXPECT_EQ(three->step, 5U);
  const auto all = parse_frames("all");
  ASSERT_TRUE(all.ok());
  EXPECT_EQ(all->begin, 0U);
  EXPECT_EQ(all->end, UINT64_MAX);
  EXPECT_EQ(all->step, 1U);
  for (const char* text : {"", ":", "3", "3:", ":3", "5:2", "5:5", "0:4:0", "0:4:1:1", "-1:4", "0:4 ", " 0:4", "a:b",
                           "0:99999999999999999999", "0:9007199254740993", "1.5:3"})
    EXPECT_FALSE(parse_frames(text).ok()) << text;
}

TEST(Units, PictureSizesStayWithinWhatIsDrawn) {
  const auto size = parse_size("1280x720");
  ASSERT_TRUE(size.ok());
  EXPECT_EQ(size->width, 1280U);
  EXPECT_EQ(size->height, 720U);
  EXPECT_TRUE(parse_size("8x8").ok());
  EXPECT_TRUE(parse_size("4096x4096").ok());
  for (const char* text : {"", "x", "640", "640x", "x480", "0x0", "7x8", "8x7", "4097x100", "100x4097", "640x480x3",
                           "-640x480", "640X480", "4294967936x480"})
    EXPECT_FALSE(parse_size(text).ok()) << text;
}

TEST(Units, BytesAreWrittenForPeople) {
  EXPECT_EQ(format_bytes(0), "0 B");
  EXPECT_EQ(format_bytes(1023), "1023 B");
  EXPECT_EQ(format_bytes(1024), "1.0 KiB");
  EXPECT_EQ(format_bytes(67108864), "64.0 MiB");
  EXPECT_EQ(format_bytes(UINT64_MAX), "17179869184.0 GiB");
}

}  // namespace
}  // namespace zc
