// SPDX-License-Identifier: Apache-2.0
#include "replay/session/replay_statistics.h"

#include <gtest/gtest.h>

namespace zc {
namespace {

FrameResult picture(double ms, std::uint32_t rays) {
  FrameResult out;
  out.pass_ms.fill(ms);
  out.total_ms = 9 * ms;
  out.counters.pixel_count = 15 * rays;
  out.counters.rays_screen = rays;
  out.counters.rays_proxy = 2 * rays;
  out.counters.rays_proxy_coarse = 3 * rays;
  out.counters.rays_sky = 4 * rays;
  out.counters.rays_lost = 5 * rays;
  return out;
}

void expect_rays(const RayCounts& rays, std::uint64_t times) {
  EXPECT_EQ(rays.total, 15 * times);
  EXPECT_EQ(rays.screen, times);
  EXPECT_EQ(rays.proxy, 2 * times);
  EXPECT_EQ(rays.proxy_coarse, 3 * times);
  EXPECT_EQ(rays.sky, 4 * times);
  EXPECT_EQ(rays.lost, 5 * times);
}

TEST(ReplayStatistics, TimesAreMediansAndRaysAreSums) {
  ReplayStatistics statistics;
  statistics.begin();
  for (const double ms : {900.0, 1.0, 2.0, 3.0, 0.5}) statistics.add_picture(picture(ms, 10));
  statistics.end_frame();
  const ReplayReport report = statistics.report();
  for (const double ms : report.pass_ms) EXPECT_EQ(ms, 2);
  EXPECT_EQ(report.total_ms, 18);
  expect_rays(report.rays, 50);
  EXPECT_EQ(report.rendered_frames, 5U);
}

TEST(ReplayStatistics, PeakMemoryIncludesWhatWasTakenSinceTheBeginning) {
  constexpr std::size_t kBytes = 64 << 20;
  ReplayStatistics statistics;
  statistics.begin();
  {
    const std::vector<char> taken(kBytes, 1);
    EXPECT_EQ(taken.back(), 1);
    statistics.end_frame();
  }
  const ReplayReport report = statistics.report();
  EXPECT_GT(report.peak_rss_bytes, report.baseline_rss_bytes + kBytes * 9 / 10);
}

TEST(ReplayStatistics, AFrameIsTheSumOfItsCamerasPictures) {
  const FrameResult sum = sum_of({picture(1, 10), picture(2, 20), picture(4, 30)});
  for (const double ms : sum.pass_ms) EXPECT_EQ(ms, 7);
  EXPECT_EQ(sum.total_ms, 63);
  ReplayStatistics statistics;
  statistics.add_picture(sum);
  expect_rays(statistics.report().rays, 60);
}

TEST(ReplayStatistics, ALimitedPoolIsLeftOutByName) {
  StreamerStatistics paging;
  paging.pool_bytes = 100;
  paging.buffer_limit_bytes = 128;
  ReplayReport report;
  report_pool_limit("full detail: ", paging, report);
  EXPECT_TRUE(report.left_out.empty());
  paging.pool_limited_by_sink = true;
  report_pool_limit("full detail: ", paging, report);
  ASSERT_EQ(report.left_out.size(), 1U);
  EXPECT_EQ(report.left_out[0], "full detail: pages beyond 100 bytes: the device binds buffers of at most 128");
}

}  // namespace
}  // namespace zc
