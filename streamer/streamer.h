// SPDX-License-Identifier: Apache-2.0
// Pages a world along a camera path under a hard memory cap.
//
// Per node: absent → reading (bytes reserved; a worker reads, verifies, decodes, assembles) → resident (in the pool)
// → absent again when room is needed. A load that is no longer selected is cancelled and returns its bytes; one that
// fails is counted and tried again after 0.1, 0.4, 1.6 and then every 10 seconds of the path, or later where a server
// asks for that, while an ancestor covers.
// Several cameras share it all: their views are one set, and a node counts for the camera that it matters to the most.
//
// An index that would take more than its share of the cap stays in its file; nodes are read in blocks when they are
// looked at, by the calling thread.
//
// Owns: index, ledger, worker threads · borrows: the source and the sink, which outlive it · threads: all methods on
// one thread; the source is called from workers, the sink only inside open() and advance() · untrusted input: index and
// pages are checked before use, and no broken file but the index and the root's is fatal.
//
// Virtual clock: a request takes the link when it is free, for bytes / bandwidth, plus the latency, and becomes
// resident in the first advance() at or after that time, whatever the workers did: the event log is the same at any
// thread count. A cancelled request leaves the link at once, and those behind it move up. Wall clock: a request becomes
// resident in the first advance() after a worker has finished it.
#pragma once

#include <cstdint>
#include <memory>
#include <span>

#include "base/result.h"
#include "streamer/page_sink.h"
#include "streamer/paging/selection.h"
#include "streamer/paging/streamer_options.h"
#include "streamer/source/source.h"
#include "streamer/statistics/paging_observer.h"
#include "streamer/statistics/statistics.h"
#include "streamer/world_format/index_view.h"

namespace zc {

class Streamer {
 public:
  // Reads the index, creates the pool and loads the root. Fails with kBudget, naming the smallest cap that works, when
  // that does not fit under the cap.
  static Result<std::unique_ptr<Streamer>> open(Source& source, const StreamerOptions& options, PageSink& sink);
  ~Streamer();
  Streamer(const Streamer&) = delete;
  Streamer& operator=(const Streamer&) = delete;

  // One frame: `views` are every camera's current view (the cameras always in the same order) and look-ahead views;
  // time_s never decreases.
  // Fails only when the sink fails, or when nodes that are not in memory can no longer be read.
  Status advance(std::span<const View> views, double time_s);

  // Borrows it from now on, beside those before.
  void observe(PagingObserver& observer);

  // Its nodes throw IndexFault when they are not in memory and their file is not as it was.
  [[nodiscard]] IndexView index() const;
  [[nodiscard]] std::uint64_t pool_words() const;

  // Resident nodes that together cover the whole world exactly once, sorted by id; valid until the next advance().
  [[nodiscard]] std::span<const std::uint32_t> rendered_cut() const;
  // Changes whenever the rendered cut or the offset of a page in it changes.
  [[nodiscard]] std::uint64_t rendered_cut_generation() const;
  [[nodiscard]] bool resident(std::uint32_t node) const;
  // Of a resident node.
  [[nodiscard]] std::uint64_t page_offset_words(std::uint32_t node) const;

  [[nodiscard]] StreamerStatistics statistics() const;

 private:
  class Impl;
  explicit Streamer(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace zc
