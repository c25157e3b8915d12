// SPDX-License-Identifier: Apache-2.0
// Worker threads that load pages in the order of submission, together within a fixed scratch memory: a worker whose
// page does not fit beside the others' waits for them. A page's files are asked for when it is submitted, so that a
// source behind a network reads more at once than there are threads. Owns its threads; they end, and are joined, when
// it goes.
// Borrows the source, which outlives it. Threads: its methods are called from one thread.
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

#include "base/result.h"
#include "streamer/source/source.h"
#include "streamer/world_format/world_index.h"

namespace zc {

class LoadWorkers {
 public:
  using Page = Result<std::vector<std::uint32_t>>;
  using Time = std::chrono::steady_clock::time_point;

  struct Loaded {
    Page page;
    unsigned worker = 0;
    Time taken_at;  // by the worker, scratch memory in hand
    Time read_at;
    Time decoded_at;
  };

  // materials: that the world has. No job may need more than scratch_bytes.
  LoadWorkers(Source& source, std::size_t materials, unsigned threads, std::uint64_t scratch_bytes);
  ~LoadWorkers();
  LoadWorkers(const LoadWorkers&) = delete;
  LoadWorkers& operator=(const LoadWorkers&) = delete;

  // Tickets are the caller's, unique and rising.
  void submit(std::uint64_t ticket, const NodeRecord& node);

  // True when the job had not started and never will; otherwise its result, which may be an error for that, is still to
  // be taken.
  bool cancel(std::uint64_t ticket);

  // Blocks until this job is done and hands over its result.
  Loaded take(std::uint64_t ticket);

  // Jobs whose result waits to be taken, in rising order. `wait`: block until there is one.
  std::vector<std::uint64_t> done(bool wait);

 private:
  struct Job {
    std::uint64_t ticket;
    NodeRecord node;
    std::unique_ptr<AsyncRead> files;
  };
  void work(unsigned worker);

  Source& source_;
  const std::size_t materials_;
  std::mutex mutex_;
  std::condition_variable queued_;
  std::condition_variable finished_;
  std::condition_variable scratch_freed_;
  std::uint64_t scratch_free_bytes_;
  std::deque<Job> queue_;
  std::map<std::uint64_t, AsyncRead*> at_work_;
  std::map<std::uint64_t, Loaded> results_;
  bool stop_ = false;
  std::vector<std::jthread> threads_;  // last: they use everything above
};

}  // namespace zc
