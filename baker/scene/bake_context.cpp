// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/scene/bake_context.h"

#include <algorithm>

namespace zc {
namespace {

// What a user sees while a stage runs; `to` of the bake is done when it ends.
struct Share {
  std::string_view name;
  double from, to;
};

constexpr std::array<Share, 10> kShares = {{{"snap", 0, 0.01},
                                            {"repair", 0.01, 0.02},
                                            {"exterior", 0.02, 0.02},
                                            {"cut", 0.02, 0.05},
                                            {"simplify", 0.05, 0.85},
                                            {"encode", 0.85, 0.92},
                                            {"atlas", 0.92, 0.93},
                                            {"light", 0.93, 0.95},
                                            {"bvh", 0.95, 1},
                                            {"index", 1, 1}}};

std::size_t index(BakeStage stage) { return static_cast<std::size_t>(stage); }

}  // namespace

void BakeContext::begin(BakeStage stage, std::size_t steps) {
  static_assert(kShares.size() == kStages);
  const std::lock_guard lock(mutex_);
  if (stage_) seconds_[index(*stage_)] += since_begin();
  stage_ = stage;
  steps_ = steps;
  done_ = 0;
  began_ = Clock::now();
  if (report_) report_(kShares[index(stage)].from, kShares[index(stage)].name);
}

void BakeContext::step() {
  const std::lock_guard lock(mutex_);
  ++done_;
  if (!report_ || !stage_ || steps_ == 0) return;
  const Share& share = kShares[index(*stage_)];
  const double part = std::min(1.0, static_cast<double>(done_) / static_cast<double>(steps_));
  report_(share.from + (share.to - share.from) * part, share.name);
}

double BakeContext::seconds(BakeStage stage) const {
  const std::lock_guard lock(mutex_);
  return seconds_[index(stage)] + (stage_ == stage ? since_begin() : 0);
}

}  // namespace zc
