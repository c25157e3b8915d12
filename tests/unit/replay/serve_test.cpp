// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "replay/serve/byte_ranges.h"
#include "replay/serve/serve_metrics.h"
#include "replay/serve/served_world.h"

namespace zc {
namespace {

// "first-last first-last", or "whole" where the header is to be ignored.
std::string ranges_of(std::string_view header, std::uint64_t bytes) {
  const auto ranges = parse_byte_ranges(header, bytes);
  if (!ranges) return "whole";
  std::string text;
  for (const ByteRange& range : *ranges)
    text += (text.empty() ? "" : " ") + std::to_string(range.first) + "-" + std::to_string(range.last);
  return text;
}

TEST(ByteRanges, are_those_that_the_file_has) {
  EXPECT_EQ(ranges_of("bytes=0-0", 10), "0-0");
  EXPECT_EQ(ranges_of("bytes=3-", 10), "3-9");
  EXPECT_EQ(ranges_of("bytes=-3", 10), "7-9");
  EXPECT_EQ(ranges_of("bytes=-30", 10), "0-9");
  EXPECT_EQ(ranges_of("bytes=8-30", 10), "8-9");
  EXPECT_EQ(ranges_of("bytes=0-1 , 4-5,\t-1", 10), "0-1 4-5 9-9");
  EXPECT_EQ(ranges_of("bytes=1-99999999999999999999", 10), "1-9");
  EXPECT_EQ(ranges_of("bytes=10-", 10), "");
  EXPECT_EQ(ranges_of("bytes=-0", 10), "");
  EXPECT_EQ(ranges_of("bytes=0-", 0), "");
  EXPECT_EQ(ranges_of("bytes=10-,0-1", 10), "0-1");
  EXPECT_EQ(ranges_of("bytes=0-18446744073709551615", UINT64_MAX), "0-18446744073709551614");
}

TEST(ByteRanges, that_make_no_sense_are_ignored) {
  for (const char* header : {"", "bytes", "bytes=", "bytes=-", "bytes=5-4", "bytes=a-", "bytes=0-a", "bytes=0x1-2",
                             "bytes= ", "bytes=1", "bytes=0-1,", "bytes=,0-1", "items=0-1", "bytes=0-1;2-3",
                             "bytes=+1-2", "bytes=--1", "bytes=0-9,0-0", "bytes=0-,0-"})
    EXPECT_EQ(ranges_of(header, 10), "whole") << header;
  std::string many = "bytes=0-0";
  for (std::size_t i = 1; i < kMostRanges; ++i) many += "," + std::to_string(i) + "-" + std::to_string(i);
  EXPECT_NE(ranges_of(many, 1000), "whole");
  EXPECT_EQ(ranges_of(many + ",900-900", 1000), "whole");
}

TEST(ByteRanges, a_version_is_named_alone_in_a_list_weakly_or_by_a_star) {
  for (const char* header : {"\"a\"", "\"b\", \"a\"", "W/\"a\"", "*", " \"a\" "})
    EXPECT_TRUE(names_version(header, "\"a\""));
  for (const char* header : {"", "\"b\"", "a", "\"aa\"", "\"a", "W/"}) EXPECT_FALSE(names_version(header, "\"a\""));
}

TEST(ServedWorld, names_are_those_that_a_world_has) {
  for (const char* name : {"world.zcw", "tileset.json", "bake.json", "zones/0/0_0.glb", "zones/12/4095_17.detail.zbvh"})
    EXPECT_TRUE(names_world_file(name)) << name;
  for (const char* name : {"",
                           "/",
                           ".",
                           "..",
                           "bake.cache",
                           "world.zcw/",
                           "zones",
                           "zones/",
                           "zones/0",
                           "zones/0/",
                           "zones/0/0_0",
                           "zones/0/0_0.",
                           "zones/0/0_0.glb/",
                           "zones/0/0_0.glb.glb",
                           "zones/-1/0_0.glb",
                           "zones/0/0_0.detail",
                           "zones/0/0_0.detail.detail.glb",
                           "zones/../world.zcw",
                           "../world.zcw",
                           "zones//0_0.glb",
                           "zones/0/_.glb",
                           "zones/0/12345678901_0.glb",
                           "Zones/0/0_0.glb"})
    EXPECT_FALSE(names_world_file(name)) << name;
  EXPECT_FALSE(names_world_file(std::string_view("world.zcw\0", 10)));
}

TEST(ServeMetrics, add_up) {
  ServeMetrics metrics;
  metrics.open_connection();
  for (const auto& [code, seconds] : {std::pair(200, 0.0001), {206, 0.02}, {304, 100.0}, {200, 0.0005}}) {
    metrics.begin_request();
    EXPECT_EQ(metrics.in_flight(), 1U);
    metrics.end_request(code, 1000, seconds);
  }
  const std::string text = metrics.prometheus();
  for (const char* line :
       {"zonecast_http_requests_total{code=\"200\"} 2\n", "zonecast_http_requests_total{code=\"304\"} 1\n",
        "zonecast_http_cache_hits_total 1\n", "zonecast_http_sent_bytes_total 4000\n", "zonecast_http_in_flight 0\n",
        "zonecast_http_connections 1\n", "_bucket{le=\"0.0005\"} 2\n", "_bucket{le=\"0.05\"} 3\n",
        "_bucket{le=\"10\"} 3\n", "_bucket{le=\"+Inf\"} 4\n", "_count 4\n"})
    EXPECT_NE(text.find(line), std::string::npos) << line << text;
}

}  // namespace
}  // namespace zc
