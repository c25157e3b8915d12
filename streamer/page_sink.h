// SPDX-License-Identifier: Apache-2.0
// Where pages go: the typed upload interface between the streamer and whoever keeps the pool (a GPU buffer joined by
// replay, the heap when nothing is rendered, a recording double in tests).
// Threads: called only on the thread that calls Streamer::open or Streamer::advance · units: 32-bit words.
#pragma once

#include <cstdint>
#include <span>

#include "base/result.h"

namespace zc {

class PageSink {
 public:
  virtual ~PageSink() = default;

  // Once, before anything else: the pool is one fixed allocation of this size.
  virtual Status create(std::uint64_t capacity_words) = 0;

  // `page` goes to [offset_words, offset_words + page.size()). The span is valid during the call only.
  virtual Status upload(std::uint64_t offset_words, std::span<const std::uint32_t> page) = 0;

  // Moves words inside the pool; the ranges may overlap (as memmove).
  virtual Status move(std::uint64_t from_words, std::uint64_t to_words, std::uint64_t count_words) = 0;
};

}  // namespace zc
