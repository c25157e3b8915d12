// SPDX-License-Identifier: Apache-2.0
// How a cap is divided before anything is loaded: what is always there, the page pool, and the working room in which
// requests are read and decoded. Pure. Units: bytes.
#pragma once

#include <cstdint>

#include "base/result.h"
#include "streamer/streamer.h"

namespace zc {

// The state that does not grow with the world: latency samples, queues, threads' stacks.
inline constexpr std::uint64_t kFixedStateBytes = 64 << 10U;
inline constexpr std::uint64_t kTopLevelBytesPerPage = 128;

struct MemoryPlan {
  std::uint64_t index_bytes = 0;  // and what the source holds
  std::uint64_t state_bytes = 0;
  std::uint64_t top_level_bytes = 0;
  std::uint64_t pool_bytes = 0;
  std::uint64_t pages = 0;            // that the pool holds at most
  std::uint64_t scratch_bytes = 0;    // shared by the workers
  std::uint64_t in_flight_bytes = 0;  // the rest: compressed bytes and decoded pages of requests
};

// What a node may need at most to be loaded under this plan.
[[nodiscard]] LoadLimits load_limits(const MemoryPlan& plan, bool include_detail);

// Fails with kBudget, naming the smallest cap that works. source_bytes: held_bytes() of the world's source.
Result<MemoryPlan> plan_memory(const WorldIndex& index, const StreamerOptions& options, std::uint64_t source_bytes = 0);

}  // namespace zc
