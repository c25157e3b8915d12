// SPDX-License-Identifier: Apache-2.0
#include "streamer/statistics/prefetch_account.h"

#include <algorithm>

#include "streamer/paging/page_loader.h"

namespace zc {

bool PrefetchAccount::asked_for(std::uint32_t node, const ErrorMeter& now, double tolerance) const {
  return node == 0 || now(index_.nodes[static_cast<std::size_t>(index_.nodes[node].parent)]).plain > tolerance;
}

void PrefetchAccount::loaded(std::uint32_t node) {
  pending_.push_back(node);
  pending_bytes_ += compressed_bytes(index_.nodes[node]);
}

void PrefetchAccount::evicted(std::uint32_t node) {
  const auto at = std::find(pending_.begin(), pending_.end(), node);
  if (at == pending_.end()) return;
  const std::uint64_t bytes = compressed_bytes(index_.nodes[node]);
  wasted_bytes_ += bytes;
  pending_bytes_ -= bytes;
  pending_.erase(at);
}

void PrefetchAccount::settle(const ErrorMeter& now, double tolerance) {
  std::erase_if(pending_, [&](std::uint32_t node) {
    if (!asked_for(node, now, tolerance)) return false;
    const std::uint64_t bytes = compressed_bytes(index_.nodes[node]);
    used_bytes_ += bytes;
    pending_bytes_ -= bytes;
    return true;
  });
}

}  // namespace zc
