// SPDX-License-Identifier: Apache-2.0
// A world as it would be had the bake stopped refining at some depth: its leaves are that depth's proxies.
// Borrows the whole world's source. Threads: as that source.
#pragma once

#include <vector>

#include "streamer/source/source.h"
#include "streamer/world_format/world_index.h"

namespace zc {

// Without full detail. A node is a leaf where one of its children would lie below `depth`.
WorldIndex cut_at_depth(const WorldIndex& index, std::uint32_t depth);

class LevelSource final : public Source {
 public:
  LevelSource(Source& whole, const WorldIndex& cut) : whole_(whole), index_(encode_world_index(cut)) {}

  Result<std::vector<std::byte>> read(const std::string& name, std::uint64_t bytes) override {
    return whole_.read(name, bytes);
  }
  Result<std::vector<std::byte>> read_all(const std::string& name, std::uint64_t limit_bytes) override {
    if (name == kWorldIndexName) return index_;
    return whole_.read_all(name, limit_bytes);
  }
  Result<std::unique_ptr<SourceFile>> open(const std::string& name, std::uint64_t limit_bytes) override {
    return name == kWorldIndexName ? Source::open(name, limit_bytes) : whole_.open(name, limit_bytes);
  }
  std::unique_ptr<AsyncRead> begin(std::vector<WantedFile> files) override { return whole_.begin(std::move(files)); }

 private:
  Source& whole_;
  std::vector<std::byte> index_;
};

}  // namespace zc
