// SPDX-License-Identifier: Apache-2.0
#include "streamer/statistics/belady.h"

#include <algorithm>
#include <iterator>
#include <limits>
#include <set>
#include <utility>

#include "base/check.h"
#include "streamer/paging/page_loader.h"
#include "streamer/paging/selection.h"

namespace zc {
namespace {

constexpr std::uint32_t kNever = std::numeric_limits<std::uint32_t>::max();

}  // namespace

void SelectionTrace::on_frame(std::span<const std::uint32_t> used) {
  if (!complete_) return;
  const std::size_t count_at = words_.size();
  words_.push_back(0);
  std::size_t b = 0;
  std::size_t u = 0;
  while (b < before_.size() || u < used.size()) {
    if (u == used.size() || (b < before_.size() && before_[b] < used[u])) {
      words_.push_back(before_[b++] << 1U);
    } else if (b == before_.size() || used[u] < before_[b]) {
      words_.push_back(used[u++] << 1U | 1U);
    } else {
      ++u;
      ++b;
    }
  }
  const std::size_t changes = words_.size() - count_at - 1;
  complete_ = words_.size() <= most_words_;
  if (!complete_ || changes == 0)
    words_.resize(count_at);
  else
    words_[count_at] = static_cast<std::uint32_t>(changes);
  before_.assign(used.begin(), used.end());
}

OptimalPaging belady(std::span<const std::uint32_t> trace, std::span<const std::uint64_t> node_bytes,
                     std::span<const std::uint64_t> read_bytes, std::uint64_t budget_bytes) {
  ZC_CHECK(read_bytes.size() == node_bytes.size());
  // next_use[w]: word of the node's next addition after word w.
  std::vector<std::uint32_t> next_use(trace.size(), kNever);
  {
    std::vector<std::size_t> steps;
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

std::optional<OptimalPaging> optimal_paging(const SelectionTrace& trace, const IndexView& index,
                                            std::uint64_t pool_bytes) {
  if (!trace.complete()) return std::nullopt;
  std::vector<std::uint32_t> words(trace.words().begin(), trace.words().end());
  const auto each_node = [&](const auto& visit) {
    for (std::size_t step = 0; step < words.size(); step += words[step] + 1)
      for (std::size_t w = step + 1; w <= step + words[step]; ++w) visit(words[w]);
  };
  std::vector<std::uint32_t> nodes;
  each_node([&](std::uint32_t word) { nodes.push_back(word >> 1U); });
  std::sort(nodes.begin(), nodes.end());
  nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
  each_node([&](std::uint32_t& word) {
    const auto at = std::lower_bound(nodes.begin(), nodes.end(), word >> 1U) - nodes.begin();
    word = static_cast<std::uint32_t>(at) << 1U | (word & 1U);
  });
  std::vector<std::uint64_t> in_pool;
  std::vector<std::uint64_t> read;
  for (const std::uint32_t n : nodes) {
    const NodeRecord node = index.nodes[n];
    in_pool.push_back(zc::pool_bytes(node));
    read.push_back(compressed_bytes(node));
  }
  return belady(words, in_pool, read, pool_bytes);
}

}  // namespace zc
