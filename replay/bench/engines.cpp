// SPDX-License-Identifier: Apache-2.0
#include "replay/bench/engines.h"

#include <array>

#include "replay/bench/bvh2_engines.h"
#include "replay/bench/embree_engine.h"
#include "replay/bench/ray_query_engine.h"

namespace zc::bench {
namespace {

std::string_view nothing(const EngineContext& /*context*/) { return {}; }

std::string_view missing_ray_query(const EngineContext& context) {
  return context.device->has_ray_query() ? "" : "the driver has no VK_KHR_ray_query";
}

std::string_view missing_builder(const EngineContext& context) {
  return context.page_builder != nullptr && *context.page_builder ? "" : "no page builder was given";
}

template <std::uint32_t kRaysPerLane, std::uint32_t kPoolPath>
std::unique_ptr<TraceEngine> zonecast(const EngineContext& context, std::string_view name) {
  return make_zonecast_engine(*context.device, {std::string(name), kRaysPerLane, kPoolPath}, *context.page_builder,
                              context.threads);
}

std::unique_ptr<TraceEngine> thesis(const EngineContext& context, std::string_view /*name*/) {
  return make_thesis_engine(*context.device);
}
std::unique_ptr<TraceEngine> bvh2(const EngineContext& context, std::string_view /*name*/) {
  return make_bvh2_engine(*context.device);
}
std::unique_ptr<TraceEngine> ray_query(const EngineContext& context, std::string_view /*name*/) {
  return make_ray_query_engine(*context.device);
}

std::string_view missing_embree(const EngineContext& /*context*/) {
  return has_embree() ? "" : "built without Embree 3";
}

template <bool kRobust>
std::unique_ptr<TraceEngine> embree(const EngineContext& context, std::string_view /*name*/) {
  return make_embree_engine(kRobust, context.threads);
}

constexpr std::array kEngines = {
    EngineEntry{"zonecast/packets", true, missing_builder, zonecast<8, gpu::kPoolTexels>},
    EngineEntry{"zonecast/packets_32", true, missing_builder, zonecast<4, gpu::kPoolTexels>},
    EngineEntry{"zonecast/packets_storage", true, missing_builder, zonecast<8, gpu::kPoolStorage>},
    EngineEntry{"zonecast/single", true, missing_builder, zonecast<0, gpu::kPoolTexels>},
    EngineEntry{"zonecast/single_storage", true, missing_builder, zonecast<0, gpu::kPoolStorage>},
    EngineEntry{"thesis", true, nothing, thesis},
    EngineEntry{"bvh2", true, nothing, bvh2},
    EngineEntry{"ray_query", true, missing_ray_query, ray_query},
    EngineEntry{"embree", false, missing_embree, embree<false>},
    EngineEntry{"embree_robust", false, missing_embree, embree<true>},
};

}  // namespace

std::span<const EngineEntry> all_engines() { return kEngines; }

}  // namespace zc::bench
