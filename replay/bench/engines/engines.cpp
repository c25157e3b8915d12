// SPDX-License-Identifier: Apache-2.0
#include "replay/bench/engines/engines.h"

#include <array>

#include "replay/bench/engines/bvh2_engines.h"
#include "replay/bench/engines/embree_engine.h"
#include "replay/bench/engines/ray_query_engine.h"

namespace zc::bench {
namespace {

std::string_view nothing(const EngineContext& /*context*/) { return {}; }

std::string_view missing_ray_query(const EngineContext& context) {
  return context.device->has_ray_query() ? "" : "the driver has no VK_KHR_ray_query";
}

template <TraceVariant kVariant>
std::string_view missing_zonecast(const EngineContext& context) {
  if (context.page_builder == nullptr || !*context.page_builder) return "no page builder was given";
  return unsupported_reason(kVariant,
                            {context.device->subgroup_size(), context.device->limits().maxComputeSharedMemorySize, 1});
}

template <TraceVariant kVariant, bool kPlain>
std::unique_ptr<TraceEngine> zonecast(const EngineContext& context, std::string_view name) {
  return make_zonecast_engine(*context.device, {std::string(name), kVariant, kPlain, context.any_hit},
                              *context.page_builder, context.threads);
}

template <TraceVariant kVariant, bool kPlain = false>
constexpr EngineEntry entry(std::string_view name) {
  return {name, true, missing_zonecast<kVariant>, zonecast<kVariant, kPlain>};
}

std::unique_ptr<TraceEngine> thesis(const EngineContext& context, std::string_view /*name*/) {
  return make_thesis_engine(*context.device, context.any_hit);
}
std::unique_ptr<TraceEngine> bvh2(const EngineContext& context, std::string_view /*name*/) {
  return make_bvh2_engine(*context.device, context.any_hit);
}
std::unique_ptr<TraceEngine> ray_query(const EngineContext& context, std::string_view /*name*/) {
  return make_ray_query_engine(*context.device, context.any_hit);
}

std::string_view missing_embree(const EngineContext& /*context*/) {
  return has_embree() ? "" : "built without Embree 3";
}

template <bool kRobust>
std::unique_ptr<TraceEngine> embree(const EngineContext& context, std::string_view /*name*/) {
  return make_embree_engine(kRobust, context.any_hit, context.threads);
}

constexpr std::array kEngines = {
    entry<TraceVariant{}>("zonecast/packets"),
    entry<TraceVariant{.rays_per_lane = 4}>("zonecast/packets_32"),
    entry<TraceVariant{.pool_path = gpu::kPoolStorage}>("zonecast/packets_storage"),
    entry<TraceVariant{.width = 32}>("zonecast/packets_w32"),
    entry<TraceVariant{.width = 128}>("zonecast/packets_w128"),
    entry<TraceVariant{.rays_per_lane = 0}>("zonecast/single"),
    entry<TraceVariant{.rays_per_lane = 0, .pool_path = gpu::kPoolStorage}>("zonecast/single_storage"),
    entry<TraceVariant{.rays_per_lane = 0, .stack_shared = true}>("zonecast/single_shared"),
    entry<TraceVariant{}, true>("zonecast/plain_packets"),
    entry<TraceVariant{.rays_per_lane = 0}, true>("zonecast/plain_single"),
    EngineEntry{"thesis", true, nothing, thesis},
    EngineEntry{"bvh2", true, nothing, bvh2},
    EngineEntry{"ray_query", true, missing_ray_query, ray_query},
    EngineEntry{"embree", false, missing_embree, embree<false>},
    EngineEntry{"embree_robust", false, missing_embree, embree<true>},
};

}  // namespace

std::span<const EngineEntry> all_engines() { return kEngines; }

}  // namespace zc::bench
