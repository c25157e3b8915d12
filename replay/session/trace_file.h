// SPDX-License-Identifier: Apache-2.0
// trace.json: what paging did on this machine and when, in the trace-event format that Perfetto and chrome://tracing
// open (Trace Event Format, Google 2016). A track for the thread of the frames, with frames and uploads; one for each
// worker, with what it read and decoded; one for the zones that wait for a worker (reserved) or for one to let go of
// them (retiring); and a counter of the ledger's bytes, class by class.
// Threads: one. Fails when the disk does; written event by event, so that a long replay takes no more memory.
#pragma once

#include <chrono>
#include <filesystem>

#include "base/result.h"
#include "replay/files/text_file.h"
#include "streamer/statistics/paging_observer.h"
#include "streamer/statistics/statistics.h"

namespace zc {

class TraceFile final : public PagingObserver {
 public:
  using Time = std::chrono::steady_clock::time_point;

  // Times count from now.
  static Result<std::unique_ptr<TraceFile>> create(const std::filesystem::path& file, unsigned workers);

  void on_span(const PagingSpan& span) override;
  void add_frame(std::uint64_t frame, Time begin, Time end, const StreamerStatistics& paging);
  Status close();

 private:
  explicit TraceFile(TextFile text) : text_(std::move(text)) {}
  [[nodiscard]] double micros(Time time) const;
  // Begins an event: everything up to its arguments.
  std::ofstream& event(const char* name, const char* phase, unsigned track, double at_us);
  void name_track(unsigned track, const std::string& name);

  TextFile text_;
  Time start_ = std::chrono::steady_clock::now();
  bool any_ = false;
};

}  // namespace zc
