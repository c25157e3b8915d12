// SPDX-License-Identifier: Apache-2.0
#include "replay/session/replay_statistics.h"

#include <algorithm>
#include <cstddef>

#include "base/platform.h"

namespace zc {
namespace {

// The upper one of two in the middle.
double median(std::vector<double>& values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::ranges::nth_element(values, middle);
  return *middle;
}

}  // namespace

void ReplayStatistics::begin() {
  reset_peak_resident_set();
  counted_.baseline_rss_bytes = resident_set_bytes();
}

void ReplayStatistics::add_picture(const FrameResult& picture) {
  const gpu::Counters& c = picture.counters;
  counted_.rays.screen += c.rays_screen;
  counted_.rays.proxy += c.rays_proxy;
  counted_.rays.proxy_coarse += c.rays_proxy_coarse;
  counted_.rays.sky += c.rays_sky;
  counted_.rays.lost += c.rays_lost;
  counted_.rays.total += c.pixel_count;
  ++counted_.rendered_frames;
  for (std::size_t i = 0; i < kPassCount; ++i) pass_ms_[i].push_back(picture.pass_ms[i]);
  total_ms_.push_back(picture.total_ms);
}

void ReplayStatistics::end_frame() {
  counted_.peak_rss_bytes = std::max(counted_.peak_rss_bytes, resident_set_bytes());
}

ReplayReport ReplayStatistics::report() {
  ReplayReport report = counted_;
  report.peak_rss_bytes = std::max(report.peak_rss_bytes, peak_resident_set_bytes());
  for (std::size_t i = 0; i < kPassCount; ++i) report.pass_ms[i] = median(pass_ms_[i]);
  report.total_ms = median(total_ms_);
  return report;
}

FrameResult sum_of(const std::vector<FrameResult>& pictures) {
  FrameResult sum;
  for (const FrameResult& one : pictures) {
    sum.counters.pixel_count += one.counters.pixel_count;
    sum.counters.rays_screen += one.counters.rays_screen;
    sum.counters.rays_proxy += one.counters.rays_proxy;
    sum.counters.rays_proxy_coarse += one.counters.rays_proxy_coarse;
    sum.counters.rays_sky += one.counters.rays_sky;
    sum.counters.rays_lost += one.counters.rays_lost;
    for (std::size_t i = 0; i < kPassCount; ++i) sum.pass_ms[i] += one.pass_ms[i];
    sum.total_ms += one.total_ms;
  }
  return sum;
}

void report_pool_limit(const std::string& scene, const StreamerStatistics& paging, ReplayReport& report) {
  if (!paging.pool_limited_by_sink) return;
  report.left_out.push_back(scene + "pages beyond " + std::to_string(paging.pool_bytes) +
                            " bytes: the device binds buffers of at most " + std::to_string(paging.buffer_limit_bytes));
}

}  // namespace zc
