// SPDX-License-Identifier: Apache-2.0
// The ways to specialise the kernels that trace. All find the same hits; which is the fastest is for the device and its
// driver to say (Renderer::choose_trace_variant).
// Thread-safe: no state.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "shaders/shared/frame.h"

namespace zc {

struct TraceVariant {
  std::uint32_t rays_per_lane = 8;             // packets of eight times as many rays: 2, 4, 8; 0: rays one by one
  std::uint32_t pool_path = gpu::kPoolTexels;  // or kPoolStorage: how shaders read pages and the ray queue
  bool stack_shared = false;                   // of rays traced one by one: in shared memory
  std::uint32_t width = 64;                    // invocations of a workgroup: 32, 64, 128

  bool operator==(const TraceVariant&) const = default;
};

// What a device and the depth of the data allow.
struct TraceLimits {
  std::uint32_t subgroup_size = 0;  // 0: invocations cannot shuffle
  std::uint32_t shared_bytes = 0;   // of a workgroup
  std::uint32_t stack_entries = 0;  // of a ray
  bool texels = true;               // texel buffers reach all of the pools
  std::uint32_t steps = 0;          // nodes that a ray may visit before it is lost: step_limit()
};

// A heavy ray of a city takes some fifty. What bounds them ends traversals of pages that nobody verified; on llvmpipe,
// whose shaders end their loops silently after 65,535 iterations over all of them, it is lower: with up to 32 triangles
// a node the count stays below that.
std::uint32_t step_limit(std::string_view device_name);

// What a name is made of, for a person.
inline constexpr std::string_view kTraceVariantNames =
    "packets64|packets32|packets16|single, then +texels|+storage, then +shared or nothing, then +w32|+w128 or nothing";

// packets64+texels, single+storage+shared+w128; a width of 64 goes without saying.
std::string trace_variant_name(const TraceVariant& variant);
std::optional<TraceVariant> parse_trace_variant(std::string_view name);
// Every one there is, the default first.
std::vector<TraceVariant> all_trace_variants();

// Empty where the kernels can be specialised so; else why not.
std::string_view unsupported_reason(const TraceVariant& variant, const TraceLimits& limits);
// The variant itself where it fits, else the nearest that does: rays one by one, a stack of their own.
TraceVariant nearest_fit(TraceVariant variant, const TraceLimits& limits);

// Milliseconds of each, measured in turn; none when there is no time left.
using MeasureVariants = std::function<Result<std::vector<double>>(std::span<const TraceVariant>)>;

// The fastest, one step after the other: packets of 64 or single rays, and which path they read by; then the smaller
// packet or the shared stack; then the width. What is not 3 % faster than a variant before it in that order does not
// displace it, so that the choice does not change with the weather.
Result<TraceVariant> choose_trace_variant(const TraceLimits& limits, const MeasureVariants& measure);

}  // namespace zc
