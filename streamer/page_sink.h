// SPDX-License-Identifier: Apache-2.0
// Where pages go: the interface between the streamer and whoever keeps the pool (a zone set on the device, the heap
// when nothing is drawn, a double in tests). The streamer decides where each page lies and which are drawn; the sink
// reports what keeping and drawing them costs, so that the streamer's cap covers that too. Threads: called only on the
// thread that calls Streamer::open or Streamer::advance · units: 32-bit words, bytes.
#pragma once

#include <cstdint>
#include <limits>
#include <span>

#include "base/result.h"

namespace zc {

// What a sink takes in memory beside the words of the pool, on the heap and on the device, from create() on: bounds,
// for any number of pages that create() may be called with.
struct SinkCosts {
  std::uint64_t fixed_bytes = 0;
  std::uint64_t bytes_per_page = 0;
  // The largest buffer that the sink can bind, and what it puts into it behind the pages (part of the bytes above).
  std::uint64_t buffer_limit_bytes = std::numeric_limits<std::uint64_t>::max();
  std::uint64_t buffer_fixed_bytes = 0;
  std::uint64_t buffer_bytes_per_page = 0;
};

// A page of the rendered cut.
struct ShownPage {
  std::uint64_t offset_words = 0;
  std::uint32_t node = 0;
  bool coarse = false;  // it stands in for finer proxies that the error tolerance asks for

  bool operator==(const ShownPage&) const = default;
};

class PageSink {
 public:
  virtual ~PageSink() = default;

  // The same at any time.
  [[nodiscard]] virtual SinkCosts costs() const = 0;

  // Once, before what follows: the pool is one fixed allocation of this size, for at most so many pages at once.
  virtual Status create(std::uint64_t capacity_words, std::uint64_t max_pages) = 0;

  // `page` goes to [offset_words, offset_words + page.size()), where no other page lies. The span is valid during the
  // call only.
  virtual Status upload(std::uint64_t offset_words, std::span<const std::uint32_t> page) = 0;

  // Moves a page inside the pool; the ranges may overlap (as memmove).
  virtual Status move(std::uint64_t from_words, std::uint64_t to_words, std::uint64_t count_words) = 0;

  // The page that was uploaded or moved to there is no longer needed. It may still be shown until the next show().
  virtual void remove(std::uint64_t offset_words) = 0;

  // What is to be drawn from now on, in the order of offsets: pages that are there. Called once whenever the pages, an
  // offset or a mark changed, after all uploads and moves of an advance().
  virtual Status show(std::span<const ShownPage> pages) = 0;
};

}  // namespace zc
