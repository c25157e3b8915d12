// SPDX-License-Identifier: Apache-2.0
#include "streamer/memory_plan.h"

#include <algorithm>
#include <string>

#include "streamer/belady.h"
#include "streamer/page_loader.h"
#include "streamer/pager_state.h"

namespace zc {
namespace {

MemoryPlan fixed_part(const WorldIndex& index, bool include_detail) {
  MemoryPlan plan;
  const std::uint64_t nodes = index.nodes.size();
  const auto pages = static_cast<std::uint64_t>(std::count_if(
      index.nodes.begin(), index.nodes.end(), [&](const NodeRecord& node) { return pageable(node, include_detail); }));
  plan.index_bytes = index.resident_bytes();
  plan.state_bytes = kFixedStateBytes + nodes * kPagerBytesPerNode;
  plan.top_level_bytes = pages * kTopLevelBytesPerNode;
  return plan;
}

std::uint64_t sum_fixed(const MemoryPlan& plan) { return plan.index_bytes + plan.state_bytes + plan.top_level_bytes; }

// At most a sixteenth of what the smallest cap leaves goes to the trace.
void plan_trace(std::uint64_t spare_bytes, std::uint64_t nodes, std::uint64_t limit_bytes, MemoryPlan& plan) {
  const std::uint64_t per_node = nodes * kBeladyBytesPerNode;
  const std::uint64_t share = spare_bytes / 16;
  if (limit_bytes == 0 || share <= per_node) return;
  plan.trace_words = std::min(limit_bytes / 4, (share - per_node) / (4 + kBeladyBytesPerWord));
  plan.trace_bytes = per_node + plan.trace_words * (4 + kBeladyBytesPerWord);
}

}  // namespace

std::uint64_t request_bytes(const NodeRecord& node) { return compressed_bytes(node) + node.page_bytes; }

bool loadable(const NodeRecord& node, const MemoryPlan& plan) {
  return request_bytes(node) <= plan.in_flight_bytes && scratch_bytes(node) <= plan.scratch_bytes;
}

bool pageable(const NodeRecord& node, bool include_detail) { return include_detail || !node.is_detail(); }

std::uint64_t smallest_cap_bytes(const WorldIndex& index, bool include_detail) {
  const NodeRecord& root = index.nodes[0];
  const std::uint64_t running =
      sum_fixed(fixed_part(index, include_detail)) + pool_bytes(root) + scratch_bytes(root) + request_bytes(root);
  const std::uint64_t opening = 2 * index.resident_bytes();  // the file and what it is decoded to
  return std::max(running, opening);
}

Result<MemoryPlan> plan_memory(const WorldIndex& index, const StreamerOptions& options) {
  const NodeRecord& root = index.nodes[0];
  const std::uint64_t smallest = smallest_cap_bytes(index, options.include_detail);
  if (options.cap_bytes < smallest)
    return Error{ErrorCode::kBudget, "a cap of " + std::to_string(options.cap_bytes) +
                                         " bytes does not hold the root; the smallest cap that works is " +
                                         std::to_string(smallest) + " bytes"};
  if (options.pool_limit_bytes < pool_bytes(root))
    return Error{ErrorCode::kBudget, "a pool of " + std::to_string(options.pool_limit_bytes) +
                                         " bytes does not hold the root's page of " + std::to_string(pool_bytes(root))};

  MemoryPlan plan = fixed_part(index, options.include_detail);
  plan_trace(options.cap_bytes - smallest, index.nodes.size(), options.trace_limit_bytes, plan);
  const std::uint64_t room = options.cap_bytes - sum_fixed(plan) - plan.trace_bytes;
  std::uint64_t scratch = scratch_bytes(root);
  std::uint64_t request = request_bytes(root);
  std::uint64_t spare = room - pool_bytes(root) - scratch - request;

  // Scratch and a request for the most demanding node, as far as that takes no more than three quarters of what is
  // spare; proxies before detail, which is left out first.
  std::uint64_t all_pages = 0;
  std::uint64_t growth_left = spare / 4 * 3;
  for (const bool detail : {false, true}) {
    for (const NodeRecord& node : index.nodes) {
      if (node.is_detail() != detail || !pageable(node, options.include_detail)) continue;
      all_pages += pool_bytes(node);
      const std::uint64_t scratch_more = std::max(scratch, scratch_bytes(node)) - scratch;
      const std::uint64_t request_more = std::max(request, request_bytes(node)) - request;
      if (scratch_more + request_more > growth_left) continue;
      growth_left -= scratch_more + request_more;
      spare -= scratch_more + request_more;
      scratch += scratch_more;
      request += request_more;
    }
  }
  // Room for more than one at once: little of it while the pool cannot hold every page, for pages are what the cap is
  // for. The number of threads has no say: what is selected must not depend on it.
  const std::uint64_t beyond_pages = spare - std::min(spare, all_pages);
  scratch += std::min(3 * scratch, std::max(spare / 16, beyond_pages / 4));
  const std::uint64_t requests =
      request + std::min((std::max(1U, options.max_in_flight) - 1) * request, std::max(spare / 8, beyond_pages / 4));

  constexpr std::uint64_t kAlign = 4 * kPageAlignWords;
  plan.scratch_bytes = scratch;
  plan.pool_bytes = std::min({options.pool_limit_bytes, all_pages, room - scratch - requests}) / kAlign * kAlign;
  plan.pool_bytes = std::max(plan.pool_bytes, pool_bytes(root));
  plan.in_flight_bytes = room - plan.scratch_bytes - plan.pool_bytes;
  return plan;
}

}  // namespace zc
