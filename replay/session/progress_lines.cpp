// SPDX-License-Identifier: Apache-2.0
#include "replay/session/progress_lines.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

namespace zc {
namespace {

std::string decimal(double value, int digits) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.*f", digits, value);
  return text.data();
}

std::string percent(double fraction) { return decimal(100 * fraction, 0) + " %"; }

// "8 s", "2 min 5 s", "3 h 20 min".
std::string duration(double seconds) {
  const auto whole = static_cast<std::uint64_t>(std::min(std::ceil(std::max(seconds, 0.0)), 1e15));
  const auto in = [](std::uint64_t count, const char* unit) { return std::to_string(count) + " " + unit; };
  if (whole < 60) return in(whole, "s");
  if (whole < 3600) return in(whole / 60, "min") + " " + in(whole % 60, "s");
  return in(whole / 3600, "h") + " " + in(whole / 60 % 60, "min");
}

// Of the whole time: a stage is as fast as those before it as far as anybody knows.
std::string rate(double now_s, double fraction, const ProgressCount& count) {
  if (!(now_s > 0)) return {};
  if (count.all > 0)
    return ", " + decimal(static_cast<double>(count.done) / now_s, 1) + " " + std::string(count.what) + "/s";
  return ", " + decimal(100 * fraction / now_s * 60, 1) + " %/min";
}

}  // namespace

std::vector<std::string> ProgressLines::update(double now_s, double fraction, std::string_view stage,
                                               const ProgressCount& count) {
  std::vector<std::string> lines;
  fraction = std::clamp(fraction, 0.0, 1.0);
  if (stage != stage_) {
    end_stage(now_s, lines);
    stage_ = stage;
    stage_began_s_ = now_s;
  }
  fraction_ = fraction;
  if (!lines.empty() || now_s < first_s_ || now_s - said_s_ < kInterval_s) return lines;
  const std::string done =
      count.all > 0 ? std::to_string(count.done) + " of " + std::to_string(count.all) + " " + std::string(count.what)
                    : percent(fraction) + " of all";
  std::string line = stage_ + ": " + done + rate(now_s, fraction, count);
  if (fraction > 0) line += ", about " + duration(now_s * (1 - fraction) / fraction) + " left";
  lines.push_back(std::move(line));
  said_s_ = now_s;
  return lines;
}

std::vector<std::string> ProgressLines::finish(double now_s) {
  std::vector<std::string> lines;
  fraction_ = 1;
  end_stage(now_s, lines);
  stage_.clear();
  return lines;
}

void ProgressLines::end_stage(double now_s, std::vector<std::string>& lines) {
  if (stage_.empty() || now_s < first_s_) return;
  lines.push_back(stage_ + ": done in " + decimal(now_s - stage_began_s_, 1) + " s, " + percent(fraction_) + " of all");
  said_s_ = now_s;
}

}  // namespace zc
