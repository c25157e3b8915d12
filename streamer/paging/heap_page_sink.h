// SPDX-License-Identifier: Apache-2.0
// The page sink of a replay that renders nothing, and of tests. Threads: as PageSink.
#pragma once

#include <vector>

#include "streamer/page_sink.h"

namespace zc {

// A pool on the heap. All of it is touched at creation, so that the process has what the ledger counts from the start.
class HeapPageSink final : public PageSink {
 public:
  // costs: of the sink that it stands in for, so that the same is paged under the same cap.
  explicit HeapPageSink(const SinkCosts& costs = {}) : costs_(costs) {}

  [[nodiscard]] SinkCosts costs() const override { return costs_; }
  Status create(std::uint64_t capacity_words, std::uint64_t max_pages) override;
  Status upload(std::uint64_t offset_words, std::span<const std::uint32_t> page) override;
  Status move(std::uint64_t from_words, std::uint64_t to_words, std::uint64_t count_words) override;
  void remove(std::uint64_t /*offset_words*/) override {}
  Status show(std::span<const ShownPage> /*pages*/) override { return {}; }

  [[nodiscard]] std::span<const std::uint32_t> words() const { return words_; }

 private:
  SinkCosts costs_;
  std::vector<std::uint32_t> words_;
};

}  // namespace zc
