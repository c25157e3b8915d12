// SPDX-License-Identifier: Apache-2.0
#include "replay/session/trace_file.h"

#include <string>
#include <utility>

namespace zc {
namespace {

constexpr unsigned kFrameTrack = 1;
constexpr unsigned kFirstWorkerTrack = 2;

}  // namespace

Result<std::unique_ptr<TraceFile>> TraceFile::create(const std::filesystem::path& file, unsigned workers) {
  ZC_ASSIGN(TextFile text, TextFile::create(file));
  std::unique_ptr<TraceFile> trace(new TraceFile(std::move(text)));
  std::ofstream& out = trace->text_.stream();
  out << std::fixed;
  out.precision(3);  // nanoseconds
  out << "{\"displayTimeUnit\":\"ms\",\"traceEvents\":[\n";
  trace->event("process_name", "M", 0, 0) << R"({"name":"zonecast"}})";
  trace->name_track(kFrameTrack, "frames");
  for (unsigned w = 0; w < workers; ++w) trace->name_track(kFirstWorkerTrack + w, "worker " + std::to_string(w));
  ZC_TRY(trace->text_.status());
  return trace;
}

double TraceFile::micros(Time time) const { return std::chrono::duration<double, std::micro>(time - start_).count(); }

std::ofstream& TraceFile::event(const char* name, const char* phase, unsigned track, double at_us) {
  std::ofstream& out = text_.stream();
  if (std::exchange(any_, true)) out << ",\n";
  out << R"({"name":")" << name << R"(","ph":")" << phase << R"(","pid":1,"tid":)" << track << R"(,"ts":)" << at_us
      << R"(,"args":)";
  return out;
}

void TraceFile::name_track(unsigned track, const std::string& name) {
  event("thread_name", "M", track, 0) << R"({"name":")" << name << "\"}}";
  event("thread_sort_index", "M", track, 0) << R"({"sort_index":)" << track << "}}";
}

void TraceFile::on_span(const PagingSpan& span) {
  const char* name = kLoadStateNames[static_cast<std::size_t>(span.state)];
  const double begin = micros(span.begin);
  if (span.state == LoadState::kReserved || span.state == LoadState::kRetiring) {
    // Many at once: a track a zone, that lasts as long as the state.
    event(name, "b", kFrameTrack, begin) << R"({"node":)" << span.node << R"(},"cat":"waiting","id":)" << span.node
                                         << '}';
    event(name, "e", kFrameTrack, micros(span.end)) << R"({},"cat":"waiting","id":)" << span.node << '}';
    return;
  }
  const unsigned track = span.state == LoadState::kUploading ? kFrameTrack : kFirstWorkerTrack + span.worker;
  event(name, "X", track, begin) << R"({"node":)" << span.node << R"(},"cat":"page","dur":)" << micros(span.end) - begin
                                 << '}';
}

void TraceFile::add_frame(std::uint64_t frame, Time begin, Time end, const StreamerStatistics& paging) {
  const double begin_us = micros(begin);
  event("advance", "X", kFrameTrack, begin_us)
      << R"({"frame":)" << frame << R"(,"missing_nodes":)" << paging.frame.missing_nodes << R"(},"cat":"frame","dur":)"
      << micros(end) - begin_us << '}';
  std::ofstream& out = event("ledger", "C", 0, micros(end));
  for (std::size_t c = 0; c < kLedgerClassCount; ++c)
    out << (c == 0 ? "{\"" : ",\"") << ledger_class_name(static_cast<LedgerClass>(c))
        << "\":" << paging.ledger_classes[c].current_bytes;
  out << "}}";
}

Status TraceFile::close() {
  text_.stream() << "\n]}\n";
  ZC_TRY(text_.status());
  return text_.close();
}

}  // namespace zc
