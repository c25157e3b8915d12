// SPDX-License-Identifier: Apache-2.0
// What the streamer keeps per node and per load, and what that counts for in the ledger.
#pragma once

#include <chrono>
#include <cstdint>

#include "streamer/ledger.h"
#include "streamer/selection.h"

namespace zc {

enum class NodePhase : std::uint8_t {
  kAbsent,
  kLoading,   // bytes are reserved; queued, reading or decoding
  kDraining,  // cancelled, but a worker is still at it and its bytes are still reserved (wall clock)
  kResident,
};

struct NodeState {
  std::uint64_t offset_words = 0;  // of a resident page
  double retry_at_s = 0;           // after a failure, on the path's clock
  std::uint32_t failures = 0;      // in a row
  std::uint32_t resident_children = 0;
  NodePhase phase = NodePhase::kAbsent;
  bool loaded_before = false;
  bool failed_before = false;
};

// A request, from issue until its result is taken.
struct Load {
  std::uint64_t ticket = 0;
  std::uint32_t node = 0;
  double issued_s = 0;
  double done_s = 0;  // modelled, virtual clock
  std::chrono::steady_clock::time_point issued_at;
  Reservation compressed;
  Reservation decoded;
};

// A resident node that may be evicted; the least loss first.
struct Eviction {
  double loss = 0;  // weighted error of the parent, which would be shown instead
  std::uint32_t node = 0;
};

// State; flags (resident, selected, loadable, cover scratch); id lists (previous selection, residents, cover and used
// nodes, now and before); cover offsets; eviction heap; the selection's own.
inline constexpr std::uint64_t kPagerBytesPerNode = sizeof(NodeState) + 4 + 6 * sizeof(std::uint32_t) +
                                                    sizeof(std::uint64_t) + sizeof(Eviction) + kSelectionBytesPerNode;

}  // namespace zc
