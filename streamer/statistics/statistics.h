// SPDX-License-Identifier: Apache-2.0
// What a replay reports about paging. Plain values, copied out of the streamer.
// Units: bytes, milliseconds on the path's clock (virtual clock) or on the steady clock (wall clock), counts.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>

#include "base/result.h"
#include "streamer/paging/ledger.h"

namespace zc {

// issued == completed + cancelled + failed + in flight.
struct RequestCounts {
  std::uint64_t issued = 0;
  std::uint64_t completed = 0;
  std::uint64_t cancelled = 0;
  std::uint64_t failed = 0;
  std::uint64_t retried = 0;  // of the issued: those that repeat a failed one
};

struct LatencySummary {
  std::uint64_t samples = 0;
  double p50_ms = 0;
  double p95_ms = 0;
  double p99_ms = 0;
  double max_ms = 0;
};

// What a page goes through on this machine, whatever the clock: milliseconds of the steady clock.
enum class LoadState : std::uint8_t {
  kReserved,   // from the request to the moment a worker takes it
  kReading,    // both files
  kDecoding,   // verifying, Draco, BVH, assembly
  kUploading,  // making room, moving pages, upload
  kRetiring,   // cancelled, until no worker is at it any more
};
inline constexpr std::size_t kLoadStateCount = 5;
inline constexpr std::array<const char*, kLoadStateCount> kLoadStateNames = {"reserved", "reading", "decoding",
                                                                             "uploading", "retiring"};

// Compressed bytes of pages that were loaded before any camera asked for their level.
struct PrefetchBytes {
  std::uint64_t used = 0;     // a camera asked for it while it was there
  std::uint64_t wasted = 0;   // evicted before any did
  std::uint64_t pending = 0;  // resident, and still to be seen
};

// A camera that moves 100 m and more in a frame, faster than 1,000 m/s.
struct CameraCutStatistics {
  std::uint64_t count = 0;
  std::uint64_t unfinished = 0;  // the next one came, or the path ended, before every wanted node was there
  LatencySummary to_target_ms;   // until every wanted node was there, on the path's clock
};

// Nodes that are selected, that no finer pages cover, and whose last request failed.
struct FailingNodes {
  std::uint32_t count = 0;
  std::optional<Error> cause;  // of the first one whose is known
};

// The frame that the last advance() made, a row of frames.csv.
struct FrameStatistics {
  double time_s = 0;
  std::uint32_t resident_nodes = 0;
  std::uint32_t cover_nodes = 0;
  std::uint32_t selected_nodes = 0;
  std::uint32_t wanted_nodes = 0;   // the cut that the tolerance asks for at the current views, as count_wanted counts
  std::uint32_t missing_nodes = 0;  // of those: not resident
  std::uint32_t in_flight = 0;
  std::uint32_t loads = 0;  // completed in this frame
  std::uint32_t evictions = 0;
  std::uint64_t ledger_bytes = 0;
  std::uint64_t resident_page_bytes = 0;
};

struct StreamerStatistics {
  std::uint64_t cap_bytes = 0;
  std::uint64_t pool_bytes = 0;
  bool index_in_memory = true;           // else its nodes are read from the file when they are looked at
  std::uint64_t index_blocks_read = 0;   // since the world was opened
  std::uint64_t buffer_limit_bytes = 0;  // the largest buffer that the sink binds
  bool pool_limited_by_sink = false;     // that, and not the cap, keeps the pool from more of the world
  LedgerUse ledger;
  std::array<LedgerUse, kLedgerClassCount> ledger_classes;  // indexed by LedgerClass

  std::uint64_t frames = 0;
  std::uint64_t frames_over_cap = 0;
  std::uint64_t wanted_level_frames = 0;  // every wanted node resident
  std::uint64_t zones_loaded = 0;         // pages that became resident, the root's included
  std::uint64_t zones_evicted = 0;
  std::uint64_t reloads = 0;  // of zones_loaded: loads of a node that was loaded before
  std::uint64_t thrash = 0;   // of the reloads: evicted at most kThrashFrames before
  std::uint64_t compactions = 0;
  std::uint64_t compacted_bytes = 0;  // moved by them
  std::uint64_t bytes_read = 0;       // compressed bytes of completed and failed requests, and what cancelled ones got
  std::uint32_t max_in_flight = 0;
  std::uint32_t failed_nodes = 0;  // nodes that failed at least once
  FailingNodes failing;            // now
  RequestCounts requests;
  PrefetchBytes prefetch;
  CameraCutStatistics camera_cuts;
  LatencySummary request_to_resident_ms;
  std::array<LatencySummary, kLoadStateCount> state_ms;  // indexed by LoadState
  std::string event_log_xxh3;                            // 16 hexadecimal digits
  FrameStatistics frame;

  // Of the frames; 1 where there are none.
  [[nodiscard]] double wanted_level_fraction() const {
    return frames == 0 ? 1.0 : static_cast<double>(wanted_level_frames) / static_cast<double>(frames);
  }
};

inline constexpr std::uint32_t kThrashFrames = 60;

// What an eviction that knows the future would have read for the same selections in the same pool.
struct OptimalPaging {
  std::uint64_t reloads = 0;
  std::uint64_t bytes_read = 0;
};

}  // namespace zc
