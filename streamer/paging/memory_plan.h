// SPDX-License-Identifier: Apache-2.0
// How a cap is divided before anything is loaded: what is always there, the page pool, and the working room in which
// requests are read and decoded. Pure. Units: bytes.
#pragma once

#include <cstdint>

#include "base/result.h"
#include "streamer/page_sink.h"
#include "streamer/paging/selection.h"
#include "streamer/paging/streamer_options.h"
#include "streamer/source/source.h"
#include "streamer/world_format/index_view.h"

namespace zc {

// The state that does not grow with the world: latency samples, queues, threads' stacks.
inline constexpr std::uint64_t kFixedStateBytes = 64 << 10U;

struct MemoryPlan {
  std::uint64_t index_bytes = 0;  // and what the source keeps
  std::uint64_t state_bytes = 0;
  std::uint64_t top_level_bytes = 0;  // the sink's, beside the pool
  std::uint64_t pool_bytes = 0;
  bool pool_limited_by_sink = false;  // the cap has room for more of the world, but the sink binds no larger buffer
  std::uint64_t pages = 0;            // that the pool contains at most
  std::uint64_t scratch_bytes = 0;    // shared by the workers
  std::uint64_t in_flight_bytes = 0;  // the rest: compressed bytes and decoded pages of requests
};

// What a node may need at most to be loaded under this plan.
[[nodiscard]] LoadLimits load_limits(const MemoryPlan& plan, bool include_detail);

// What an index may take of the memory before it is known whether it fits under the cap: what no cap of this size has
// room for is not read, however long a server sends; a small one is, to name the cap that works.
[[nodiscard]] std::uint64_t index_limit_bytes(std::uint64_t cap_bytes);

// The share of a cap that an index's nodes may take: a small world's all fit, of a large one's some blocks do.
[[nodiscard]] std::uint64_t index_room_bytes(std::uint64_t cap_bytes);

// What is there only while a world opens, beside what the index keeps.
[[nodiscard]] std::uint64_t opening_bytes(const IndexView& index, const SourceCosts& source);

// The smallest cap under which a world opens: index, node state, the root's page, what loading it takes and what the
// sink takes beside it.
[[nodiscard]] std::uint64_t smallest_cap_bytes(const IndexView& index, const SourceCosts& source = {},
                                               const SinkCosts& sink = {});

// Fails with kBudget, naming the smallest cap that works, or the buffer that the sink would have to bind.
Result<MemoryPlan> plan_memory(const IndexView& index, const StreamerOptions& options, const SourceCosts& source = {},
                               const SinkCosts& sink = {});

}  // namespace zc
