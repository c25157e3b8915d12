// SPDX-License-Identifier: Apache-2.0
#include "streamer/belady.h"

#include <iterator>
#include <limits>
#include <set>
#include <utility>

#include "base/check.h"

namespace zc {
namespace {

constexpr std::uint32_t kNever = std::numeric_limits<std::uint32_t>::max();

}  // namespace

void SelectionTrace::record(std::span<const std::uint32_t> before, std::span<const std::uint32_t> after) {
  if (!complete_ || capacity_words_ == 0) {
    complete_ = false;
    return;
  }
  const std::size_t count_at = words_.size();
  const auto put = [&](std::uint32_t word) {
    if (words_.size() == capacity_words_)
      complete_ = false;
    else
      words_.push_back(word);
  };
  put(0);
  std::size_t b = 0;
  std::size_t a = 0;
  while (complete_ && (b < before.size() || a < after.size())) {
    if (a == after.size() || (b < before.size() && before[b] < after[a])) {
      put(before[b++] << 1U);
    } else if (b == before.size() || after[a] < before[b]) {
      put(after[a++] << 1U | 1U);
    } else {
      ++a;
      ++b;
    }
  }
  const std::size_t changes = words_.size() - count_at - 1;
  if (!complete_ || changes == 0)
    words_.resize(count_at);
  else
    words_[count_at] = static_cast<std::uint32_t>(changes);
}

OptimalPaging belady(std::span<const std::uint32_t> trace, std::span<const std::uint64_t> node_bytes,
                     std::span<const std::uint64_t> read_bytes, std::uint64_t budget_bytes) {
  ZC_CHECK(read_bytes.size() == node_bytes.size());
  // next_use[w]: word of the node's next addition after word w.
  std::vector<std::uint32_t> next_use(trace.size(), kNever);
  {
    std::size_t step_count = 0;
    for (std::size_t at = 0; at < trace.size(); at += trace[at] + 1) ++step_count;
    std::vector<std::size_t> steps;
    steps.reserve(step_count);  // growing by doubling would take more than the ledger counts
    for (std::size_t at = 0; at < trace.size(); at += trace[at] + 1) steps.push_back(at);
    std::vector<std::uint32_t> upcoming(node_bytes.size(), kNever);
    for (auto step = steps.rbegin(); step != steps.rend(); ++step) {
      for (std::size_t w = *step + 1; w <= *step + trace[*step]; ++w) {
        const std::uint32_t node = trace[w] >> 1U;
        ZC_CHECK(node < node_bytes.size());
        next_use[w] = upcoming[node];
        if ((trace[w] & 1U) != 0) upcoming[node] = static_cast<std::uint32_t>(w);
      }
    }
  }

  std::vector<std::uint32_t> idle_until(node_bytes.size(), kNever);
  std::vector<bool> loaded_before(node_bytes.size());
  std::vector<bool> cached(node_bytes.size());
  std::set<std::pair<std::uint32_t, std::uint32_t>> idle;  // cached and not selected: next use, node
  std::uint64_t used_bytes = 0;
  OptimalPaging optimal;
  for (std::size_t step = 0; step < trace.size(); step += trace[step] + 1) {
    const std::size_t end = step + 1 + trace[step];
    for (std::size_t w = step + 1; w < end; ++w) {
      const std::uint32_t node = trace[w] >> 1U;
      if ((trace[w] & 1U) == 0) {
        idle_until[node] = next_use[w];
        idle.emplace(next_use[w], node);
      } else if (cached[node]) {
        idle.erase({idle_until[node], node});
      } else {
        cached[node] = true;
        used_bytes += node_bytes[node];
        optimal.bytes_read += read_bytes[node];
        if (loaded_before[node]) ++optimal.reloads;
        loaded_before[node] = true;
      }
    }
    while (used_bytes > budget_bytes && !idle.empty()) {
      const auto furthest = std::prev(idle.end());
      cached[furthest->second] = false;
      used_bytes -= node_bytes[furthest->second];
      idle.erase(furthest);
    }
  }
  return optimal;
}

}  // namespace zc
