// SPDX-License-Identifier: Apache-2.0
#include "streamer/paging/memory_plan.h"

#include <algorithm>
#include <limits>
#include <string>
#include <vector>

#include "streamer/paging/page_loader.h"
#include "streamer/paging/pager_state.h"
#include "streamer/source/index_file.h"

namespace zc {
namespace {

constexpr std::uint64_t kSmallIndexBytes = 16U << 20U;
constexpr std::uint64_t kLeastIndexRoom = 1U << 20U;
constexpr std::uint64_t kIndexShare = 8;  // one part of so many

// What is kept for each page that may be there, beside the page.
std::uint64_t kept_bytes_per_page(const SinkCosts& sink) { return kPagerBytesPerPage + sink.bytes_per_page; }

std::uint64_t request_bytes(const NodeRecord& node) { return compressed_bytes(node) + node.page_bytes; }

// Of the nodes that may be paged.
struct PageSums {
  std::uint64_t count = 0;
  std::uint64_t pool_bytes = 0;
  std::uint64_t smallest_pool_bytes = std::numeric_limits<std::uint64_t>::max();
  // The pool is planned for pages that are on average no smaller than this; were they, fewer of them would be selected.
  [[nodiscard]] std::uint64_t planned_pool_bytes() const {
    return std::max(smallest_pool_bytes, pool_bytes / count / 2);
  }
  std::uint64_t largest_scratch_bytes = 0;
  std::uint64_t largest_request_bytes = 0;
};

PageSums sum_pages(const IndexView& index, bool include_detail) {
  PageSums sums;
  for (std::uint32_t n = 0; n < index.nodes.size(); ++n) {
    const NodeRecord node = index.nodes[n];
    if (!include_detail && node.is_detail()) continue;
    const std::uint64_t bytes = pool_bytes(node);
    ++sums.count;
    sums.pool_bytes += bytes;
    sums.smallest_pool_bytes = std::min(sums.smallest_pool_bytes, bytes);
    sums.largest_scratch_bytes = std::max(sums.largest_scratch_bytes, scratch_bytes(node));
    sums.largest_request_bytes = std::max(sums.largest_request_bytes, request_bytes(node));
  }
  return sums;
}

// What is there whatever is loaded, with the root's share of what is kept per page.
std::uint64_t fixed_bytes(const IndexView& index, std::uint64_t index_bytes, const SinkCosts& sink) {
  return index_bytes + kFixedStateBytes + index.nodes.size() * kPagerBytesPerNode + sink.fixed_bytes +
         kept_bytes_per_page(sink);
}

// What one load may take.
struct LoadRoom {
  std::uint64_t scratch = 0;
  std::uint64_t request = 0;
};

// A node's children.
struct Family {
  LoadRoom needs;
  std::uint64_t bytes = 0;
};

std::uint64_t count_families(const IndexView& index) {
  std::uint64_t families = 0;
  for (std::uint32_t n = 0; n < index.nodes.size(); ++n) families += index.nodes[n].child_count > 0 ? 1 : 0;
  return families;
}

// The room with which the most page bytes can be there: more of it lets larger pages be loaded, less of it leaves more
// of `spare` to the pool. A page is of use only with its siblings, and below its parent. `least`: the root's.
LoadRoom most_useful_room(const IndexView& index, bool include_detail, std::uint64_t spare, const LoadRoom& least) {
  const NodeTable& nodes = index.nodes;
  std::vector<LoadRoom> needs(nodes.size());  // of a node with its siblings and all above it
  std::vector<Family> families;
  families.reserve(count_families(index));
  needs[0] = least;
  for (std::size_t n = 0; n < nodes.size(); ++n) {
    const NodeRecord node = nodes[n];
    if (node.child_count == 0 || (!include_detail && nodes[node.first_child].is_detail())) continue;
    Family family{needs[n], 0};
    for (std::size_t c = node.first_child; c < std::size_t{node.first_child} + node.child_count; ++c) {
      const NodeRecord child = nodes[c];
      family.needs.scratch = std::max(family.needs.scratch, scratch_bytes(child));
      family.needs.request = std::max(family.needs.request, request_bytes(child));
      family.bytes += pool_bytes(child);
    }
    for (std::size_t c = node.first_child; c < std::size_t{node.first_child} + node.child_count; ++c)
      needs[c] = family.needs;
    families.push_back(family);
  }
  const auto sum = [](const LoadRoom& room) { return room.scratch + room.request; };
  std::stable_sort(families.begin(), families.end(),
                   [&](const Family& a, const Family& b) { return sum(a.needs) < sum(b.needs); });
  LoadRoom room = least;
  LoadRoom best = least;
  std::uint64_t reached = 0;
  std::uint64_t most = 0;
  for (const Family& family : families) {
    room = {std::max(room.scratch, family.needs.scratch), std::max(room.request, family.needs.request)};
    const std::uint64_t more = sum(room) - sum(least);
    if (more > spare) break;
    reached += family.bytes;
    if (std::min(reached, spare - more) <= most) continue;
    most = std::min(reached, spare - more);
    best = room;
  }
  return best;
}

// The largest pool that fits into `room` beside what is kept per page but the root's.
std::uint64_t fit_pool(std::uint64_t room, std::uint64_t root_bytes, const PageSums& pages,
                       std::uint64_t bytes_per_page) {
  const std::uint64_t more = (pages.count - 1) * bytes_per_page;
  const std::uint64_t planned = (room - root_bytes) / (pages.planned_pool_bytes() + bytes_per_page);
  return std::max(root_bytes + planned * pages.planned_pool_bytes(), room - std::min(room, more));
}

}  // namespace

LoadLimits load_limits(const MemoryPlan& plan, bool include_detail) {
  return {plan.in_flight_bytes, plan.scratch_bytes, include_detail};
}

std::uint64_t index_limit_bytes(std::uint64_t cap_bytes) { return std::max(cap_bytes, kSmallIndexBytes); }

std::uint64_t index_room_bytes(std::uint64_t cap_bytes) { return std::max(kLeastIndexRoom, cap_bytes / kIndexShare); }

std::uint64_t opening_bytes(const IndexView& index, const SourceCosts& source) {
  // The file that it is decoded from.
  if (HeldIndex::fits(index.nodes.size(), kLeastIndexRoom, source)) return HeldIndex::bytes(index, 0, {});
  // It is checked, then the plan is made; sorting takes half of what it sorts.
  return std::max(check_index_bytes(index.nodes.size()),
                  index.nodes.size() * sizeof(LoadRoom) + count_families(index) * (sizeof(Family) * 3 / 2));
}

std::uint64_t smallest_cap_bytes(const IndexView& index, const SourceCosts& source, const SinkCosts& sink) {
  const NodeRecord root = index.nodes[0];
  const std::uint64_t running =
      fixed_bytes(index, 0, sink) + pool_bytes(root) + scratch_bytes(root) + request_bytes(root);
  const std::uint64_t beside_nodes = source.held_bytes + std::max(running, opening_bytes(index, source));
  if (HeldIndex::fits(index.nodes.size(), kLeastIndexRoom, source))
    return beside_nodes + HeldIndex::bytes(index, kLeastIndexRoom, source);
  // Of a larger cap the nodes take a larger share.
  const std::uint64_t beside_share = beside_nodes + HeldIndex::bytes(index, 0, source);
  return std::max(beside_share + kLeastIndexRoom, beside_share + beside_share / (kIndexShare - 1) + 1);
}

Result<MemoryPlan> plan_memory(const IndexView& index, const StreamerOptions& options, const SourceCosts& source,
                               const SinkCosts& sink) {
  const NodeRecord root = index.nodes[0];
  const std::uint64_t smallest = smallest_cap_bytes(index, source, sink);
  if (options.cap_bytes < smallest)
    return Error{ErrorCode::kBudget, "a cap of " + std::to_string(options.cap_bytes) +
                                         " bytes is too small for the root; the smallest cap that works is " +
                                         std::to_string(smallest) + " bytes"};
  const std::uint64_t least_buffer = sink.buffer_fixed_bytes + sink.buffer_bytes_per_page + pool_bytes(root);
  if (sink.buffer_limit_bytes < least_buffer)
    return Error{ErrorCode::kBudget, "the root's page takes a buffer of " + std::to_string(least_buffer) +
                                         " bytes, and the device binds " + std::to_string(sink.buffer_limit_bytes)};

  const std::uint64_t index_bytes =
      source.held_bytes + HeldIndex::bytes(index, index_room_bytes(options.cap_bytes), source);
  const PageSums pages = sum_pages(index, options.include_detail);
  MemoryPlan plan;
  const std::uint64_t bytes_per_page = kept_bytes_per_page(sink);
  const std::uint64_t room = options.cap_bytes - fixed_bytes(index, index_bytes, sink);
  LoadRoom load{scratch_bytes(root), request_bytes(root)};
  std::uint64_t spare = room - pool_bytes(root) - load.scratch - load.request;
  const std::uint64_t before = load.scratch + load.request;
  if (pages.largest_scratch_bytes + pages.largest_request_bytes - before <= spare / 4)
    load = {pages.largest_scratch_bytes, pages.largest_request_bytes};
  else
    load = most_useful_room(index, options.include_detail, spare, load);
  spare -= load.scratch + load.request - before;

  // Room for more than one at once: little of it while the pool has no room for every page, for pages are what the cap
  // is for. The number of threads does not count: what is selected must not depend on it.
  const std::uint64_t beyond_pages = spare - std::min(spare, pages.pool_bytes + pages.count * bytes_per_page);
  const std::uint64_t scratch =
      load.scratch * (1 + std::min<std::uint64_t>(3, std::max(spare / 16, beyond_pages / 4) / load.scratch));
  const std::uint64_t requests = load.request + std::min((std::max(1U, options.max_in_flight) - 1) * load.request,
                                                         std::max(spare / 12, beyond_pages / 4));

  constexpr std::uint64_t kAlign = 4 * kPageAlignWords;
  plan.scratch_bytes = scratch;
  const std::uint64_t affordable =
      std::min(pages.pool_bytes, fit_pool(room - scratch - requests, pool_bytes(root), pages, bytes_per_page));
  const std::uint64_t bound = fit_pool(sink.buffer_limit_bytes - sink.buffer_fixed_bytes - sink.buffer_bytes_per_page,
                                       pool_bytes(root), pages, sink.buffer_bytes_per_page);
  plan.pool_bytes = std::min(affordable, bound) / kAlign * kAlign;
  plan.pool_limited_by_sink = bound < affordable / kAlign * kAlign;
  plan.pages = 1 + std::min(pages.count - 1, (plan.pool_bytes - pool_bytes(root)) / pages.planned_pool_bytes());
  plan.index_bytes = index_bytes;
  plan.state_bytes = kFixedStateBytes + index.nodes.size() * kPagerBytesPerNode + plan.pages * kPagerBytesPerPage;
  plan.top_level_bytes = sink.fixed_bytes + plan.pages * sink.bytes_per_page;
  plan.in_flight_bytes = room - plan.scratch_bytes - plan.pool_bytes - (plan.pages - 1) * bytes_per_page;
  return plan;
}

}  // namespace zc
