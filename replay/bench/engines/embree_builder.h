// SPDX-License-Identifier: Apache-2.0
// Embree's tree builders (rtcBuildBVH) over the triangles of one zone: peers of our own in `zonecast bench build`.
// Units: those of the triangles. Threads: any number may build at once. Fails when Embree does.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "base/result.h"

namespace zc::bench {

struct PeerBox {
  std::array<float, 3> min{};
  std::array<float, 3> max{};
};

struct PeerReference {
  PeerBox box;  // of the triangle, or of a piece of it
  std::uint32_t triangle = 0;
};

struct PeerNode {
  std::array<PeerBox, 8> boxes{};           // of the children
  std::array<std::uint32_t, 8> children{};  // their nodes, which lie behind this one
  std::uint32_t child_count = 0;            // 0: a leaf
  std::vector<PeerReference> references;    // of a leaf
};

class EmbreeTree {
 public:
  virtual ~EmbreeTree() = default;
  [[nodiscard]] virtual std::vector<PeerNode> nodes() const = 0;  // the root comes first
};

enum class EmbreeQuality : std::uint8_t { kMorton, kSah, kSplits };

struct EmbreeOptions {
  EmbreeQuality quality = EmbreeQuality::kSah;
  std::uint32_t width = 2;           // most children of a node, at most 8
  std::uint32_t leaf_triangles = 1;  // most of a leaf
};

class EmbreeBuilder {
 public:
  virtual ~EmbreeBuilder() = default;
  // The tree must not outlive the builder.
  virtual Result<std::unique_ptr<EmbreeTree>> build(std::span<const std::array<std::array<float, 3>, 3>> triangles,
                                                    const EmbreeOptions& options) = 0;
};

// Nothing where Embree is not built in.
std::unique_ptr<EmbreeBuilder> make_embree_builder(unsigned threads);

}  // namespace zc::bench
