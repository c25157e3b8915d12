// SPDX-License-Identifier: Apache-2.0
// Runs work over [0, count) in chunks on a number of threads. Deterministic as far as the work on one index depends on
// that index alone. The caller's thread works too.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <thread>
#include <vector>

namespace zc::bench {

// work(begin, end) must not throw.
template <std::size_t kChunk = 1024, class Work>
void parallel_chunks(std::size_t count, unsigned threads, const Work& work) {
  std::atomic<std::size_t> next = 0;
  const auto run = [&] {
    for (std::size_t begin = next.fetch_add(kChunk); begin < count; begin = next.fetch_add(kChunk))
      work(begin, std::min(begin + kChunk, count));
  };
  std::vector<std::jthread> helpers;
  for (unsigned i = 1; i < threads; ++i) helpers.emplace_back(run);
  run();
}

}  // namespace zc::bench
