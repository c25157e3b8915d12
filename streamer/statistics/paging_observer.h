// SPDX-License-Identifier: Apache-2.0
// Who wants to see paging at work: what each page goes through, and when, and which pages a frame uses. Called inside
// Streamer::advance, on its thread. Units: the steady clock of this machine.
#pragma once

#include <chrono>
#include <cstdint>
#include <span>

#include "streamer/statistics/statistics.h"

namespace zc {

struct PagingSpan {
  LoadState state = LoadState::kReserved;
  std::uint32_t node = 0;
  unsigned worker = 0;  // that did it; of reading and decoding alone
  std::chrono::steady_clock::time_point begin;
  std::chrono::steady_clock::time_point end;
};

class PagingObserver {
 public:
  virtual ~PagingObserver() = default;
  virtual void on_span(const PagingSpan&) {}
  // At its end: the nodes that were selected and resident, sorted by id.
  virtual void on_frame(std::span<const std::uint32_t>) {}
};

}  // namespace zc
