// SPDX-License-Identifier: Apache-2.0
#include "replay/session/frame_log.h"

namespace zc {

Result<FrameLog> FrameLog::create(const std::filesystem::path& file, bool with_rays) {
  ZC_ASSIGN(TextFile text, TextFile::create(file));
  std::ofstream& out = text.stream();
  out.precision(12);  // long paths keep their milliseconds
  out << "frame,time_s,ledger_bytes,resident_page_bytes,resident_nodes,cover_nodes,selected_nodes,wanted_nodes,"
         "missing_nodes,in_flight,loads,evictions";
  if (with_rays) {
    out << ",rays_total,rays_screen,rays_proxy,rays_proxy_coarse,rays_sky,rays_lost";
    for (const char* pass : kPassNames) out << ',' << pass << "_ms";
    out << ",total_ms";
  }
  out << '\n';
  ZC_TRY(text.status());
  return FrameLog(std::move(text));
}

Status FrameLog::add(std::uint64_t frame, const FrameStatistics& paging, const FrameResult* drawn) {
  std::ofstream& out = text_.stream();
  out << frame << ',' << paging.time_s << ',' << paging.ledger_bytes << ',' << paging.resident_page_bytes << ','
      << paging.resident_nodes << ',' << paging.cover_nodes << ',' << paging.selected_nodes << ','
      << paging.wanted_nodes << ',' << paging.missing_nodes << ',' << paging.in_flight << ',' << paging.loads << ','
      << paging.evictions;
  if (drawn != nullptr) {
    const gpu::Counters& c = drawn->counters;
    out << ',' << c.pixel_count << ',' << c.rays_screen << ',' << c.rays_proxy << ',' << c.rays_proxy_coarse << ','
        << c.rays_sky << ',' << c.rays_lost;
    for (const double ms : drawn->pass_ms) out << ',' << ms;
    out << ',' << drawn->total_ms;
  }
  out << '\n';
  return text_.status();
}

}  // namespace zc
