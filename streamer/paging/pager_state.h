// SPDX-License-Identifier: Apache-2.0
// What the streamer keeps per node and per load, and what that counts for in the ledger.
#pragma once

#include <chrono>
#include <cstdint>

#include "streamer/page_sink.h"
#include "streamer/paging/ledger.h"
#include "streamer/paging/rendered_cut.h"
#include "streamer/paging/selection.h"

namespace zc {

enum class NodePhase : std::uint8_t {
  kAbsent,
  kLoading,   // bytes are reserved; queued, reading or decoding
  kDraining,  // cancelled, but a worker is still at it and its bytes are still reserved (wall clock)
  kResident,
};

// All zero for a node that nothing ever asked for.
struct NodeState {
  double retry_at_s;            // after a failure, on the path's clock
  std::uint32_t evicted_frame;  // of the last eviction
  std::uint16_t failures;       // in a row
  std::uint8_t loaded_before : 1;
  std::uint8_t failed_before : 1;
  std::uint8_t prefetched : 1;  // loaded, or being loaded, before any camera asked for its level
  NodePhase phase;
};

// A request, from issue until its result is taken.
struct Load {
  std::uint64_t ticket = 0;
  std::uint32_t node = 0;
  double issued_s = 0;
  // On the modelled link, virtual clock: the bytes are on it from start to end, and here a latency later.
  double start_s = 0;
  double end_s = 0;
  std::chrono::steady_clock::time_point issued_at;
  std::chrono::steady_clock::time_point cancelled_at;  // of a draining one
  Reservation compressed;
  Reservation decoded;
};

// A resident node that may be evicted; the least loss first.
struct Eviction {
  double loss = 0;  // weighted error of what would be shown instead; below 0 where nothing changes
  std::uint32_t node = 0;
};

// Per node of the world: state, whether it is selected, its place in the pool, what the rendered cut counts.
inline constexpr std::uint64_t kPagerBytesPerNode =
    sizeof(NodeState) + 1 + sizeof(std::uint32_t) + RenderedCut::kBytesPerNode;

// Per page that can be there at once: id lists (residents, prefetched, used, and the rendered cut now and before); the
// cut's offsets, and what of it the sink is shown; eviction heap; the selection's own.
inline constexpr std::uint64_t kPagerBytesPerPage =
    5 * sizeof(std::uint32_t) + sizeof(std::uint64_t) + sizeof(ShownPage) + sizeof(Eviction) + kSelectionBytesPerPage;

}  // namespace zc
