// SPDX-License-Identifier: Apache-2.0
#include "replay/session/statistics_json.h"

#include <nlohmann/json.hpp>

namespace zc {

namespace {

nlohmann::ordered_json percentiles(const LatencySummary& s) {
  return {{"p50", s.p50_ms}, {"p95", s.p95_ms}, {"p99", s.p99_ms}, {"max", s.max_ms}};
}

nlohmann::ordered_json statistics_json(const ReplayReport& report) {
  const StreamerStatistics& s = report.streaming;
  nlohmann::ordered_json summary;
  summary["frames"] = s.frames;
  summary["cap_bytes"] = s.cap_bytes;
  summary["pool_bytes"] = s.pool_bytes;
  summary["pool_limited_by_device"] = s.pool_limited_by_sink;
  summary["index_in_memory"] = s.index_in_memory;
  summary["index_blocks_read"] = s.index_blocks_read;
  summary["peak_ledger_bytes"] = s.ledger.peak_bytes;
  summary["frames_over_cap"] = s.frames_over_cap;
  summary["peak_rss_bytes"] = report.peak_rss_bytes;
  summary["baseline_rss_bytes"] = report.baseline_rss_bytes;
  summary["zones_loaded"] = s.zones_loaded;
  summary["zones_evicted"] = s.zones_evicted;
  summary["reloads"] = s.reloads;
  summary["reloads_optimal"] = nullptr;
  if (report.optimal) summary["reloads_optimal"] = report.optimal->reloads;
  summary["thrash"] = s.thrash;
  summary["wanted_level_fraction"] = s.wanted_level_fraction();
  summary["request_to_resident_ms"] = percentiles(s.request_to_resident_ms);
  nlohmann::ordered_json state_ms;
  for (std::size_t i = 0; i < kLoadStateCount; ++i) state_ms[kLoadStateNames[i]] = percentiles(s.state_ms[i]);
  summary["state_ms"] = std::move(state_ms);
  summary["camera_cuts"] = {{"count", s.camera_cuts.count},
                            {"unfinished", s.camera_cuts.unfinished},
                            {"to_target_ms", percentiles(s.camera_cuts.to_target_ms)}};
  summary["requests"] = {{"issued", s.requests.issued},
                         {"completed", s.requests.completed},
                         {"cancelled", s.requests.cancelled},
                         {"failed", s.requests.failed},
                         {"retried", s.requests.retried}};
  summary["failed_nodes"] = s.failed_nodes;
  summary["failing_nodes"] = s.failing.count;
  summary["host_failing_nodes"] = report.host_failing.count;
  summary["bytes_read"] = s.bytes_read;
  summary["bytes_read_optimal"] = nullptr;
  if (report.optimal) summary["bytes_read_optimal"] = report.optimal->bytes_read;
  summary["prefetch"] = {
      {"used_bytes", s.prefetch.used}, {"wasted_bytes", s.prefetch.wasted}, {"pending_bytes", s.prefetch.pending}};
  summary["compactions"] = s.compactions;
  summary["compacted_bytes"] = s.compacted_bytes;
  summary["rays"] = {{"total", report.rays.total}, {"screen", report.rays.screen},
                     {"proxy", report.rays.proxy}, {"proxy_coarse", report.rays.proxy_coarse},
                     {"sky", report.rays.sky},     {"lost", report.rays.lost}};
  nlohmann::ordered_json pass_ms;
  for (std::size_t i = 0; i < kPassCount; ++i) pass_ms[kPassNames[i]] = report.pass_ms[i];
  pass_ms["total"] = report.total_ms;
  summary["pass_ms"] = std::move(pass_ms);
  summary["rendered_frames"] = report.rendered_frames;
  summary["host_bytes"] = report.host_bytes;
  summary["validation_messages"] = report.validation_messages;
  summary["left_out"] = report.left_out;
  summary["event_log_xxh3"] = s.event_log_xxh3;
  summary["device"] = report.device;
  summary["driver"] = report.driver;
  for (const char* key : {"trace_variant", "trace_variant_origin", "trace_variant_measure_ms"}) summary[key] = nullptr;
  if (!report.trace_variant.empty()) {
    summary["trace_variant"] = report.trace_variant;
    summary["trace_variant_origin"] = report.trace_variant_origin;
    if (report.measure_ms > 0) summary["trace_variant_measure_ms"] = report.measure_ms;
  }
  summary["version"] = ZONECAST_VERSION;
  nlohmann::ordered_json ledger;
  for (std::size_t i = 0; i < kLedgerClassCount; ++i) {
    ledger[ledger_class_name(static_cast<LedgerClass>(i))] = {{"current_bytes", s.ledger_classes[i].current_bytes},
                                                              {"peak_bytes", s.ledger_classes[i].peak_bytes}};
  }
  const nlohmann::ordered_json source = {{"requests", report.source.requests},
                                         {"failed", report.source.failed},
                                         {"bytes_received", report.source.bytes_received},
                                         {"not_modified", report.source.not_modified},
                                         {"cache_hits", report.source.cache_hits},
                                         {"cache_damaged", report.source.cache_damaged}};
  return {{"summary", std::move(summary)}, {"ledger", std::move(ledger)}, {"source", source}};
}

}  // namespace

std::string statistics_text(const ReplayReport& report) { return statistics_json(report).dump(2) + "\n"; }

}  // namespace zc
