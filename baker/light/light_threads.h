// SPDX-License-Identifier: GPL-3.0-or-later
// Threads of its own for the light: while an Embree device lives that builds on one thread, TBB has no more than one.
#pragma once

#include <atomic>
#include <cstddef>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

namespace zc {

// Calls work(i) for every i below count, from `threads` threads; in ascending order of start. Throws the first thing
// that any work threw, once all have stopped.
template <class Work>
void for_each_on_threads(std::size_t count, unsigned threads, const Work& work) {
  std::atomic<std::size_t> next = 0;
  std::exception_ptr thrown;
  std::once_flag first;
  const auto run = [&] {
    try {
      for (std::size_t i = next++; i < count; i = next++) work(i);
    } catch (...) {
      std::call_once(first, [&] { thrown = std::current_exception(); });
      next = count;
    }
  };
  {
    std::vector<std::jthread> others;
    for (unsigned t = 1; t < threads; ++t) others.emplace_back(run);
    run();
  }
  if (thrown) std::rethrow_exception(thrown);
}

}  // namespace zc
