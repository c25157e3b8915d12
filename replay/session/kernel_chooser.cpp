// SPDX-License-Identifier: Apache-2.0
#include "replay/session/kernel_chooser.h"

#include <cmath>
#include <optional>
#include <utility>

#include "runtime/tracing/trace_queue.h"

namespace zc {
namespace {

// A replay that was not asked to measure begins no further step after this.
constexpr double kMeasureMs = 2000;

}  // namespace

KernelChooser::KernelChooser(const ReplayOptions& options, VariantKey key, bool reflects)
    : options_(options), key_(std::move(key)), reflects_(reflects) {}

TraceVariant KernelChooser::first(const TraceLimits& limits) {
  TraceVariant variant = options_.renderer.trace;
  if (options_.kernel != KernelChoice::kFixed) {
    std::optional<TraceVariant> cached;
    if (options_.kernel == KernelChoice::kAuto) cached = read_cached_variant(options_.variant_cache, key_);
    if (cached && !unsupported_reason(*cached, limits).empty()) cached.reset();  // another world's
    variant = cached.value_or(TraceVariant{});
    origin_ = cached ? "cached" : "default";
    // Not unasked where a wall clock paces the frames: those behind would be measured with it.
    const bool paced = options_.streamer.clock == ClockKind::kWall && options_.kernel == KernelChoice::kAuto;
    to_measure_ = !cached && !paced && reflects_;
  }
  const std::string_view why_not = unsupported_reason(variant, limits);
  if (why_not.empty()) return variant;
  variant = nearest_fit(variant, limits);
  options_.warn({ErrorCode::kDevice, "traced by " + trace_variant_name(variant) + ": " + std::string(why_not)});
  return variant;
}

void KernelChooser::after_frame(StandInHost& host, const gpu::Counters& counters) {
  if (!to_measure_ || counters.ray_count < TraceQueue::kRaysToChoose) return;
  to_measure_ = false;
  const auto started = std::chrono::steady_clock::now();
  const double budget_ms = options_.kernel == KernelChoice::kAuto ? kMeasureMs : INFINITY;
  const Result<bool> complete = host.choose_trace_variant(counters.ray_count, budget_ms);
  paused_ += std::chrono::steady_clock::now() - started;
  // A driver that refuses one kernel may still take the others.
  if (!complete) return options_.warn(complete.error());
  measure_ms_ = std::chrono::duration<double, std::milli>(paused_).count();
  origin_ = "measured";
  if (options_.variant_cache.empty() || !*complete) return;  // the next replay finds more of them compiled
  if (Status kept = write_cached_variant(options_.variant_cache, key_, host.trace_variant()); !kept.ok())
    options_.warn(kept.error());
}

}  // namespace zc
