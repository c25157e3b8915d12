// SPDX-License-Identifier: Apache-2.0
// By which kernels a replay traces: those asked for, those that an earlier one cached, or those that are measured on
// one of its frames.
// Borrows the options. Threads: one. Never fails: what goes wrong is a warning, and the kernels stay as they are.
#pragma once

#include <chrono>
#include <string>

#include "replay/session/replay_options.h"
#include "replay/session/variant_cache.h"
#include "runtime/tracing/trace_variant.h"

namespace zc {

class KernelChooser {
 public:
  using Duration = std::chrono::steady_clock::duration;

  // key: the device that traces. reflects: there is anything to trace.
  KernelChooser(const ReplayOptions& options, VariantKey key, bool reflects);

  // Those to begin with; the choice is final unless there is something to measure.
  TraceVariant first(const TraceLimits& limits);
  // After a frame, on its own rays and zones, which are what this device will have to trace: measures, where that is
  // due.
  void after_frame(StandInHost& host, const gpu::Counters& counters);

  // fixed, cached, measured; default: nothing was.
  [[nodiscard]] const std::string& origin() const { return origin_; }
  // Of a measurement that came to a choice.
  [[nodiscard]] double measure_ms() const { return measure_ms_; }
  // What measuring took of the replay's time.
  [[nodiscard]] Duration paused() const { return paused_; }

 private:
  const ReplayOptions& options_;
  VariantKey key_;
  bool reflects_;
  bool to_measure_ = false;  // as soon as a frame queues enough rays
  std::string origin_ = "fixed";
  double measure_ms_ = 0;
  Duration paused_ = {};
};

}  // namespace zc
