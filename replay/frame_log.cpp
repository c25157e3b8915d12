// SPDX-License-Identifier: Apache-2.0
#include "replay/frame_log.h"

#include "replay/replay_session.h"

namespace zc {

Result<FrameLog> FrameLog::create(const std::filesystem::path& file, bool with_rays) {
  FrameLog log;
  log.file_ = file;
  log.temporary_ = file;
  log.temporary_ += ".tmp";
  log.stream_.open(log.temporary_, std::ios::trunc);
  log.stream_.precision(12);  // long paths keep their milliseconds
  log.stream_ << "frame,time_s,ledger_bytes,resident_page_bytes,resident_nodes,cover_nodes,selected_nodes,wanted_nodes,"
                 "missing_nodes,in_flight,loads,evictions";
  if (with_rays) {
    log.stream_ << ",rays_total,rays_screen,rays_proxy,rays_proxy_coarse,rays_sky,rays_lost";
    for (const char* pass : kPassNames) log.stream_ << ',' << pass << "_ms";
    log.stream_ << ",total_ms";
  }
  log.stream_ << '\n';
  if (!log.stream_) return Error{ErrorCode::kIo, "cannot write", file.string()};
  return log;
}

FrameLog::~FrameLog() {
  if (!stream_.is_open()) return;
  stream_.close();
  std::error_code ignored;  // the temporary file is all that could stay, and a failure already has its own message
  std::filesystem::remove(temporary_, ignored);
}

Status FrameLog::add(std::uint64_t frame, const FrameStatistics& paging, const FrameResult* drawn) {
  stream_ << frame << ',' << paging.time_s << ',' << paging.ledger_bytes << ',' << paging.resident_page_bytes << ','
          << paging.resident_nodes << ',' << paging.cover_nodes << ',' << paging.selected_nodes << ','
          << paging.wanted_nodes << ',' << paging.missing_nodes << ',' << paging.in_flight << ',' << paging.loads << ','
          << paging.evictions;
  if (drawn != nullptr) {
    const gpu::Counters& c = drawn->counters;
    stream_ << ',' << c.pixel_count << ',' << c.rays_screen << ',' << c.rays_proxy << ',' << c.rays_proxy_coarse << ','
            << c.rays_sky << ',' << c.rays_lost;
    for (const double ms : drawn->pass_ms) stream_ << ',' << ms;
    stream_ << ',' << drawn->total_ms;
  }
  stream_ << '\n';
  if (!stream_) return Error{ErrorCode::kIo, "cannot write", file_.string()};
  return {};
}

Status FrameLog::close() {
  stream_.close();
  std::error_code failure;
  std::error_code ignored;
  if (!stream_) {
    std::filesystem::remove(temporary_, ignored);
    return Error{ErrorCode::kIo, "cannot write", file_.string()};
  }
  std::filesystem::rename(temporary_, file_, failure);
  if (failure) {
    std::filesystem::remove(temporary_, ignored);
    return Error{ErrorCode::kIo, "cannot rename into place: " + failure.message(), file_.string()};
  }
  return {};
}

}  // namespace zc
