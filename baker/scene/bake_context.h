// SPDX-License-Identifier: GPL-3.0-or-later
// What every stage of a bake is given beside its input: threads, a clock for what it takes and whom it reports its
// progress to. Results never depend on it. A stage is `Result<Out> stage(In&&, BakeContext&)`, where In names what the
// stage needs of the whole city: the rest of it may be a part.
// Threads: begin() from one at a time, step() from any.
#pragma once

#include <tbb/parallel_for.h>

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <mutex>
#include <optional>
#include <string_view>
#include <vector>

#include "base/result.h"

namespace zc {

enum class BakeStage : std::uint8_t {
  kSnap,
  kRepair,
  kExterior,
  kCut,
  kSimplify,
  kEncode,
  kAtlas,
  kLight,
  kBvh,
  kIndex
};

class BakeContext {
 public:
  // Called one call at a time, from any thread; fraction in 0..1.
  using Report = std::function<void(double fraction, std::string_view stage)>;

  explicit BakeContext(unsigned threads = 1, Report report = {}) : threads_(threads), report_(std::move(report)) {}
  BakeContext(const BakeContext&) = delete;
  BakeContext& operator=(const BakeContext&) = delete;

  [[nodiscard]] unsigned threads() const { return threads_; }

  // A stage of so many steps begins, and the one before it ends.
  void begin(BakeStage stage, std::size_t steps = 0);
  void step();
  // Wall clock, of all stages that ended, and of the one that has not.
  [[nodiscard]] double seconds(BakeStage stage) const;

  // Runs work(i), which returns a Status, for all i in parallel, each a step; of several errors the one with the least
  // i is returned.
  template <class Work>
  Status for_each(std::size_t count, const Work& work) {
    std::vector<std::optional<Error>> errors(count);
    tbb::parallel_for(
        tbb::blocked_range<std::size_t>(0, count, 1),
        [&](const tbb::blocked_range<std::size_t>& range) {
          for (std::size_t i = range.begin(); i != range.end(); ++i) {
            if (Status status = work(i); !status.ok()) errors[i] = std::move(status).error();
            step();
          }
        },
        tbb::simple_partitioner());
    for (auto& error : errors)
      if (error) return *std::move(error);
    return {};
  }

 private:
  using Clock = std::chrono::steady_clock;
  static constexpr std::size_t kStages = static_cast<std::size_t>(BakeStage::kIndex) + 1;

  [[nodiscard]] double since_begin() const { return std::chrono::duration<double>(Clock::now() - began_).count(); }

  unsigned threads_;
  Report report_;
  mutable std::mutex mutex_;
  std::optional<BakeStage> stage_;
  std::size_t steps_ = 0;
  std::size_t done_ = 0;
  Clock::time_point began_;
  std::array<double, kStages> seconds_ = {};
};

}  // namespace zc
