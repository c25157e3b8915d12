// SPDX-License-Identifier: Apache-2.0
#include "runtime/tracing/trace_variant.h"

#include <algorithm>

namespace zc {
namespace {

constexpr std::uint32_t kLaneGroupSize = 8;  // as in packet.glsl
constexpr std::uint32_t kEntryBytes = 8;     // of a stack
constexpr double kTie = 0.97;                // of a time: what is not clearly less is the same

}  // namespace

std::string trace_variant_name(const TraceVariant& variant) {
  std::string name =
      variant.rays_per_lane == 0 ? "single" : "packets" + std::to_string(kLaneGroupSize * variant.rays_per_lane);
  name += variant.pool_path == gpu::kPoolTexels ? "+texels" : "+storage";
  if (variant.stack_shared) name += "+shared";
  if (variant.width != TraceVariant{}.width) name += "+w" + std::to_string(variant.width);
  return name;
}

std::optional<TraceVariant> parse_trace_variant(std::string_view name) {
  for (const TraceVariant& variant : all_trace_variants())
    if (trace_variant_name(variant) == name) return variant;
  return std::nullopt;
}

std::uint32_t step_limit(std::string_view device_name) {
  return device_name.find("llvmpipe") != std::string_view::npos ? 1900 : 1U << 16U;
}

std::vector<TraceVariant> all_trace_variants() {
  std::vector<TraceVariant> variants;
  for (const std::uint32_t rays_per_lane : {8U, 4U, 2U, 0U})
    for (const std::uint32_t pool_path : {gpu::kPoolTexels, gpu::kPoolStorage})
      for (const bool stack_shared : {false, true})
        for (const std::uint32_t width : {64U, 32U, 128U})
          variants.push_back({rays_per_lane, pool_path, stack_shared, width});
  return variants;
}

std::string_view unsupported_reason(const TraceVariant& variant, const TraceLimits& limits) {
  // In larger subgroups lane groups part ways, and nothing in SPIR-V without SPV_KHR_maximal_reconvergence says that
  // the lanes of one lane group still meet at its shuffles: on an H100 some did not.
  if (variant.rays_per_lane > 0 && limits.subgroup_size != kLaneGroupSize)
    return "packets need subgroups of just eight that shuffle";
  if (variant.pool_path == gpu::kPoolTexels && !limits.texels)
    return "the pool is larger than the texel buffers that the device binds";
  if (variant.stack_shared && std::uint64_t{limits.stack_entries} * variant.width * kEntryBytes > limits.shared_bytes)
    return "the stacks of a workgroup do not fit the device's shared memory";
  return {};
}

TraceVariant nearest_fit(TraceVariant variant, const TraceLimits& limits) {
  if (limits.subgroup_size != kLaneGroupSize) variant.rays_per_lane = 0;
  if (!limits.texels) variant.pool_path = gpu::kPoolStorage;
  if (!unsupported_reason(variant, limits).empty()) variant.stack_shared = false;
  return variant;
}

Result<TraceVariant> choose_trace_variant(const TraceLimits& limits, const MeasureVariants& measure) {
  TraceVariant best = nearest_fit({}, limits);
  // Between the best so far and those of the others that fit; returns their times, in that order.
  const auto race = [&](std::vector<TraceVariant> variants) -> Result<std::vector<double>> {
    std::erase_if(variants, [&](const TraceVariant& v) { return v == best || !unsupported_reason(v, limits).empty(); });
    if (variants.empty()) return std::vector<double>();
    variants.insert(variants.begin(), best);
    ZC_ASSIGN(std::vector<double> times_ms, measure(variants));
    std::size_t first = 0;
    for (std::size_t i = 1; i < times_ms.size(); ++i)
      if (times_ms[i] < kTie * times_ms[first]) first = i;
    best = variants[first];
    return times_ms;
  };
  // The two paths are told apart by single rays, whose kernels are compiled in a fraction of the time.
  ZC_ASSIGN(const std::vector<double> times_ms, race({{0, gpu::kPoolTexels}, {0, gpu::kPoolStorage}}));
  const std::size_t count = times_ms.size();
  if (count > 1 && times_ms[count - 1] < kTie * times_ms[count - 2]) ZC_TRY(race({{8, gpu::kPoolStorage}}));
  TraceVariant other = best;
  other.rays_per_lane /= 2;
  other.stack_shared = best.rays_per_lane == 0;
  ZC_TRY(race({other}));
  TraceVariant narrow = best;
  narrow.width = 32;
  TraceVariant wide = best;
  wide.width = 128;
  ZC_TRY(race({narrow, wide}));
  return best;
}

}  // namespace zc
