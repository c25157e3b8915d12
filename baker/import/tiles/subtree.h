// SPDX-License-Identifier: GPL-3.0-or-later
// A subtree of an implicit tiling, binary or JSON: which tiles, contents and child subtrees there are. Source: OGC
// 22-025r4, section 8 (subtrees, availability); 3DTILES_implicit_tiling. Untrusted input: every bit that may be asked
// for is in the file. Thread-safe for const use.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "baker/import/tiles/tile_files.h"
#include "baker/import/tiles/tileset_file.h"
#include "base/result.h"

namespace zc {

// `uri` with {level}, {x}, {y} and {z} of the tile in their places.
std::string fill_template(std::string_view uri, const TileAddress& tile);

// One bit for each of so many, or the same for all.
class Availability {
 public:
  explicit Availability(bool constant) : constant_(constant) {}
  explicit Availability(std::vector<std::byte> bits) : bits_(std::move(bits)) {}
  [[nodiscard]] bool at(std::uint64_t i) const {
    return bits_.empty() ? constant_ : (std::to_integer<unsigned>(bits_[i / 8]) >> (i % 8) & 1U) != 0;
  }

 private:
  bool constant_ = false;
  std::vector<std::byte> bits_;
};

struct Subtree {
  Availability tiles{false};           // level by level, each in Morton order
  std::vector<Availability> contents;  // likewise; of the tile's first content, its second, ...
  Availability child_subtrees{false};  // of the level below the last
};

// Buffers in files of their own lie within `root`. Nothing when one of them is not there and may be skipped.
Result<std::optional<Subtree>> read_subtree(std::span<const std::byte> bytes, const std::filesystem::path& path,
                                            const std::filesystem::path& root, const ImplicitTiling& tiling,
                                            TileFiles& files);

}  // namespace zc
