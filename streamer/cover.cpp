// SPDX-License-Identifier: Apache-2.0
#include "streamer/cover.h"

#include "base/check.h"

namespace zc {
namespace {

constexpr std::uint8_t kCovered = 1;    // by itself or below
constexpr std::uint8_t kRefinable = 2;  // all children are covered
constexpr std::uint8_t kReached = 4;    // no ancestor is shown

}  // namespace

void compute_cover(const WorldIndex& index, std::span<const std::uint8_t> resident, std::span<std::uint8_t> scratch,
                   std::vector<std::uint32_t>& cover) {
  ZC_CHECK(resident.size() == index.nodes.size() && scratch.size() == index.nodes.size() && resident[0] != 0);
  // Parents come before children in the index: one pass up, one pass down.
  for (std::size_t n = index.nodes.size(); n-- > 0;) {
    const NodeRecord& node = index.nodes[n];
    bool refinable = node.child_count > 0;
    for (std::size_t c = node.first_child; refinable && c < std::size_t{node.first_child} + node.child_count; ++c)
      refinable = (scratch[c] & kCovered) != 0;
    scratch[n] =
        static_cast<std::uint8_t>((resident[n] != 0 || refinable ? kCovered : 0) | (refinable ? kRefinable : 0));
  }
  cover.clear();
  scratch[0] |= kReached;
  for (std::uint32_t n = 0; n < index.nodes.size(); ++n) {
    if ((scratch[n] & kReached) == 0) continue;
    const NodeRecord& node = index.nodes[n];
    if ((scratch[n] & kRefinable) == 0) {
      cover.push_back(n);
      continue;
    }
    for (std::size_t c = node.first_child; c < std::size_t{node.first_child} + node.child_count; ++c)
      scratch[c] |= kReached;
  }
}

}  // namespace zc
