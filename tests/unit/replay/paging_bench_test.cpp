// SPDX-License-Identifier: Apache-2.0
// An index of many nodes, read piece by piece.
#include "replay/bench/paging_bench.h"

#include <gtest/gtest.h>

#include <cstring>

#include "streamer/world_format/world_index.h"

namespace zc::bench {
namespace {

TEST(SyntheticIndex, IsReadOnceInOrderAndEveryDamageIsFound) {
  const WorldIndex before = make_synthetic_index(20000);
  ASSERT_EQ(before.nodes.size(), 20000U);
  std::vector<std::byte> bytes = encode_world_index(before);
  std::uint64_t next = 0;
  const ReadAt read = [&](std::uint64_t offset, std::span<std::byte> out) -> Status {
    EXPECT_EQ(offset, next);
    next += out.size();
    std::memcpy(out.data(), bytes.data() + offset, out.size());
    return {};
  };
  const Result<WorldIndex> after = decode_world_index(bytes.size(), read, "w");
  ASSERT_TRUE(after.ok()) << after.error().describe();
  EXPECT_EQ(next, bytes.size());
  ASSERT_EQ(after->nodes.size(), before.nodes.size());
  EXPECT_EQ(std::memcmp(after->nodes.data(), before.nodes.data(), before.nodes.size() * sizeof(NodeRecord)), 0);

  for (std::size_t at = 1000; at < bytes.size(); at += 333331) {
    bytes[at] ^= std::byte{4};
    EXPECT_FALSE(decode_world_index(bytes, "w").ok()) << at;
    bytes[at] ^= std::byte{4};
  }
  const ReadAt failing = [&](std::uint64_t offset, std::span<std::byte> out) -> Status {
    if (offset > 1000000) return Error{ErrorCode::kIo, "gone", "w"};
    std::memcpy(out.data(), bytes.data() + offset, out.size());
    return {};
  };
  const Result<WorldIndex> failed = decode_world_index(bytes.size(), failing, "w");
  ASSERT_FALSE(failed.ok());
  EXPECT_EQ(failed.error().message, "gone");
}

}  // namespace
}  // namespace zc::bench
