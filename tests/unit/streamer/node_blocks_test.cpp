// SPDX-License-Identifier: Apache-2.0
// Nodes that stay in the index file: the same as those in memory, whatever is kept of them, or a fault.
#include "streamer/world_format/node_blocks.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "streamer/paging/heap_page_sink.h"
#include "streamer/paging/memory_plan.h"
#include "streamer/paging/selection.h"
#include "streamer/source/index_file.h"
#include "streamer/streamer.h"
#include "tests/unit/same_bytes.h"
#include "tests/unit/streamer/tiny_world.h"

namespace zc {
namespace {

constexpr std::uint32_t kNodes = 7000;  // more than the least room has place for

// A quadtree of zones that are all the same. `file` is what a test changes under an open world.
class ManyNodes final : public Source {
 public:
  ManyNodes() : zone_(test::make_tiny_zone(8, 4, 4096, 0, root_)) {
    WorldIndex index;
    index.materials.resize(2);
    index.header.bounds_max = {4096 << 7, 4096 << 7, 4096 << 7};
    index.nodes.push_back(at(-1, 0, 0, 0));
    for (std::uint32_t n = 0; index.nodes.size() < kNodes; ++n) {
      const NodeRecord parent = index.nodes[n];
      index.nodes[n].first_child = static_cast<std::uint32_t>(index.nodes.size());
      index.nodes[n].child_count = std::min<std::uint32_t>(4, kNodes - index.nodes[n].first_child);
      for (std::uint32_t c = 0; c < index.nodes[n].child_count; ++c)
        index.nodes.push_back(
            at(static_cast<std::int32_t>(n), parent.depth + 1, 2 * parent.cell_x + c % 2, 2 * parent.cell_y + c / 2));
    }
    file = encode_world_index(index);
  }

  Result<std::vector<std::byte>> read(const std::string& name, std::uint64_t /*bytes*/) override {
    return name.ends_with(".glb") ? zone_.glb : zone_.bvh;
  }
  Result<std::vector<std::byte>> read_all(const std::string& /*name*/, std::uint64_t /*limit_bytes*/) override {
    return file;
  }
  Result<std::unique_ptr<SourceFile>> open(const std::string& name, std::uint64_t limit_bytes) override {
    if (costs().whole_files) return Source::open(name, limit_bytes);
    return std::unique_ptr<SourceFile>(std::make_unique<Parts>(file));
  }
  [[nodiscard]] SourceCosts costs() const override { return {.whole_files = whole_files}; }

  std::vector<std::byte> file;
  bool whole_files = false;

 private:
  class Parts final : public SourceFile {
   public:
    explicit Parts(const std::vector<std::byte>& bytes) : bytes_(bytes) {}
    [[nodiscard]] std::uint64_t size_bytes() const override { return bytes_.size(); }
    Status read(std::uint64_t offset_bytes, std::span<std::byte> out) const override {
      if (offset_bytes + out.size() > bytes_.size()) return Error{ErrorCode::kIo, "ends early", "world.zcw"};
      std::copy_n(bytes_.begin() + static_cast<std::ptrdiff_t>(offset_bytes), out.size(), out.begin());
      return {};
    }

   private:
    const std::vector<std::byte>& bytes_;
  };

  [[nodiscard]] NodeRecord at(std::int32_t parent, std::uint32_t depth, std::uint32_t x, std::uint32_t y) const {
    NodeRecord node = root_;
    node.parent = parent;
    node.depth = depth;
    node.cell_x = x;
    node.cell_y = y;
    node.step_shift = 7 - depth;
    const std::int32_t side = 4096 << node.step_shift;
    node.origin = {static_cast<std::int32_t>(x) * side, static_cast<std::int32_t>(y) * side, 0};
    node.bounds_min = node.origin;
    for (std::size_t axis = 0; axis < 3; ++axis) node.bounds_max[axis] = node.origin[axis] + side;
    node.error_max_m = 0.1F * static_cast<float>(1U << node.step_shift);
    return node;
  }

  NodeRecord root_;
  test::TinyZone zone_;
};

ReadAt reader(const std::vector<std::byte>& file) {
  return [&file](std::uint64_t offset, std::span<std::byte> out) -> Status {
    std::copy_n(file.begin() + static_cast<std::ptrdiff_t>(offset), out.size(), out.begin());
    return {};
  };
}

TEST(NodeBlocks, AreTheNodesOfTheFileHoweverFewAreKept) {
  const ManyNodes world;
  const auto all = decode_world_index(world.file, "");
  ASSERT_TRUE(all.ok()) << all.error().describe();
  auto checked = check_world_index(world.file.size(), reader(world.file), NodeBlocks::kNodesPerBlock, "");
  ASSERT_TRUE(checked.ok()) << checked.error().describe();
  for (const std::uint64_t room : std::initializer_list<std::uint64_t>{0, 5 * NodeBlocks::kBlockBytes, 1U << 30U}) {
    NodeBlocks blocks(kNodes, checked->block_xxh3, reader(world.file), "", room);
    std::mt19937 random(7);
    for (int i = 0; i < 20'000; ++i) {
      const auto n = static_cast<std::uint32_t>(random() % kNodes);
      const NodeRecord node = blocks.record(n);
      ASSERT_TRUE(test::same_bytes(node, all->nodes[n])) << n;
    }
    if (room > world.file.size()) {
      EXPECT_LE(blocks.blocks_read(), (kNodes + 63) / 64) << "none is read twice";
    }
  }
}

TEST(NodeBlocks, KeepWhatIsAskedForAgain) {
  const ManyNodes world;
  auto checked = check_world_index(world.file.size(), reader(world.file), NodeBlocks::kNodesPerBlock, "");
  ASSERT_TRUE(checked.ok());
  NodeBlocks blocks(kNodes, checked->block_xxh3, reader(world.file), "", 8 * (NodeBlocks::kBlockBytes + 8));
  for (std::uint32_t n = 0; n < kNodes; ++n) {  // a scan with one block between its steps
    [[maybe_unused]] const NodeRecord scanned = blocks.record(n);
    [[maybe_unused]] const NodeRecord again = blocks.record(3);
  }
  // Once more where the hand first comes round and finds all of them asked for.
  EXPECT_LE(blocks.blocks_read(), (kNodes + 63) / 64 + 1) << "the scan drove out what is in use";
}

TEST(NodeBlocks, AreRefusedForWhatTheWholeIndexIsRefusedFor) {
  const ManyNodes world;
  const auto agree = [](std::vector<std::byte> file) {
    const auto whole = decode_world_index(file, "w");
    const auto parts = check_world_index(file.size(), reader(file), NodeBlocks::kNodesPerBlock, "w");
    ASSERT_EQ(whole.ok(), parts.ok());
    if (!whole.ok()) {
      EXPECT_EQ(whole.error().describe(), parts.error().describe());
    }
  };
  agree(world.file);
  std::mt19937 random(3);
  auto index = decode_world_index(world.file, "");
  ASSERT_TRUE(index.ok());
  for (int i = 0; i < 200; ++i) {  // with right hashes
    WorldIndex broken = *index;
    NodeRecord& node = broken.nodes[random() % 400];
    reinterpret_cast<std::uint32_t*>(&node)[random() % 20] = static_cast<std::uint32_t>(random() % 9000);  // NOLINT
    agree(encode_world_index(broken));
  }
  for (int i = 0; i < 20; ++i) {
    std::vector<std::byte> damaged = world.file;
    damaged[random() % damaged.size()] ^= std::byte{4};
    agree(damaged);
  }
}

TEST(NodeBlocks, SelectAsNodesInMemoryDo) {
  ManyNodes world;
  const auto all = decode_world_index(world.file, "");
  ASSERT_TRUE(all.ok());
  const auto held = HeldIndex::open(world, 1U << 20U, 1U << 30U);
  ASSERT_TRUE(held.ok()) << held.error().describe();
  ASSERT_FALSE((*held)->in_memory());
  for (const double at : {0.0, 500.0, 1900.0}) {
    const View view{{at, at, 2}};
    Selection whole;
    Selection parts;
    const SelectionQuery query{.views = std::span(&view, 1), .budget_bytes = 1U << 20U, .tolerance = 0.001};
    select_nodes(*all, query, whole);
    select_nodes((*held)->view(), query, parts);
    EXPECT_GT(whole.nodes.size(), 100U);
    EXPECT_EQ(whole.by_priority, parts.by_priority);
  }
}

StreamerOptions small_cap() { return {.cap_bytes = 6U << 20U, .tolerance = 0.001, .settle = true}; }

TEST(NodeBlocks, PageAWorldWhoseIndexIsNotInMemory) {
  ManyNodes world;
  HeapPageSink sink;
  auto streamer = Streamer::open(world, small_cap(), sink);
  ASSERT_TRUE(streamer.ok()) << streamer.error().describe();
  for (int f = 0; f < 40; ++f) {
    const View view{{50.0 * f, 40.0 * f, 2}};
    ASSERT_TRUE((*streamer)->advance(std::span(&view, 1), f).ok());
  }
  const StreamerStatistics statistics = (*streamer)->statistics();
  EXPECT_FALSE(statistics.index_in_memory);
  EXPECT_GT(statistics.index_blocks_read, 0U);
  EXPECT_EQ(statistics.requests.failed, 0U);
  EXPECT_GT(statistics.frame.cover_nodes, 100U);
  EXPECT_LT(statistics.ledger_classes[static_cast<std::size_t>(LedgerClass::kIndex)].peak_bytes,
            kNodes * sizeof(NodeRecord));
}

TEST(NodeBlocks, AFileThatChangesUnderAnOpenWorldIsAnError) {
  for (const bool cut : {true, false}) {
    ManyNodes world;
    HeapPageSink sink;
    auto streamer = Streamer::open(world, small_cap(), sink);
    ASSERT_TRUE(streamer.ok()) << streamer.error().describe();
    if (cut)
      world.file.resize(world.file.size() / 2);
    else
      std::ranges::fill(std::span(world.file).subspan(sizeof(WorldHeader)), std::byte{7});
    Status moved;
    for (int f = 0; f < 10 && moved.ok(); ++f) {
      const View here{{300.0 * f, 200.0 * f, 2}};
      moved = (*streamer)->advance(std::span(&here, 1), f);
    }
    ASSERT_FALSE(moved.ok());
    EXPECT_NE(moved.error().describe().find(cut ? "ends early" : "has changed since the world was opened"),
              std::string::npos)
        << moved.error().describe();
  }
}

// Every cap from the smallest on opens, whether the nodes are in memory under it or not; one byte less does not.
TEST(NodeBlocks, EveryCapFromTheSmallestOpens) {
  for (const bool whole : {true, false}) {
    ManyNodes world;
    world.whole_files = whole;
    const auto index = decode_world_index(world.file, "");
    ASSERT_TRUE(index.ok());
    HeapPageSink sink;
    const std::uint64_t smallest = smallest_cap_bytes(*index, world.costs(), sink.costs());
    EXPECT_EQ(smallest < kNodes * sizeof(NodeRecord) * 2, !whole);
    EXPECT_FALSE(Streamer::open(world, {.cap_bytes = smallest - 1}, sink).ok());
    for (std::uint64_t cap = smallest; cap < 20U << 20U; cap += cap < smallest + 3 ? 1 : cap / 17) {
      HeapPageSink fresh;
      const auto streamer = Streamer::open(world, {.cap_bytes = cap}, fresh);
      ASSERT_TRUE(streamer.ok()) << cap << ": " << streamer.error().describe();
      EXPECT_LE((*streamer)->statistics().ledger.peak_bytes, cap);
      EXPECT_EQ((*streamer)->statistics().index_in_memory, whole || cap / 8 >= kNodes * sizeof(NodeRecord)) << cap;
    }
  }
}

}  // namespace
}  // namespace zc
