// SPDX-License-Identifier: Apache-2.0
#include "replay/bench/engines/bvh2_engines.h"

#include <bit>

#include "replay/bench/engines/gpu_engine.h"
#include "replay/bench/engines/sah_tree.h"
#include "replay/bench/engines/stopwatch.h"
#include "spirv/bench.h"

namespace zc::bench {
namespace {

// About one and a half triangles a leaf, as in the thesis: 41 bytes of nodes a triangle.
constexpr SahOptions kThesisTree = {2, 0.5F};
constexpr SahOptions kBvh2Tree = {4, 1};
constexpr std::size_t kMostTriangles = 1 << 27;
constexpr std::uint32_t kLeafFlag = 0x80000000U;

Status check_count(const BenchScene& scene) {
  if (scene.triangles.size() < kMostTriangles) return {};
  return Error{ErrorCode::kUnsupported, "2^27 triangles or more"};
}

// The buffers' content, in words.
struct Layout {
  std::vector<std::uint32_t> nodes;
  std::vector<std::uint32_t> triangles;

  void add(float value) { nodes.push_back(std::bit_cast<std::uint32_t>(value)); }
  void add(const std::array<float, 3>& p) {
    for (const float value : p) add(value);
  }
};

Status upload(Device& device, const Layout& layout, std::vector<Buffer>& buffers) {
  for (const auto* words : {&layout.nodes, &layout.triangles}) {
    ZC_ASSIGN(Buffer buffer, make_filled_buffer(device, std::as_bytes(std::span(*words))));
    buffers.push_back(std::move(buffer));
  }
  return {};
}

std::uint64_t bytes_of(const Layout& layout) { return 4 * (layout.nodes.size() + layout.triangles.size()); }

// Depth first: an inner node's first child follows it, the second one follows the first one's subtree.
void add_thesis_node(const SahTree& tree, std::uint32_t at, Layout& layout) {
  const SahNode& node = tree.nodes[at];
  const std::size_t base = layout.nodes.size();
  layout.add(node.box.min);
  layout.nodes.push_back(0);
  layout.add(node.box.max);
  layout.nodes.push_back(node.count > 0 ? node.count << 28U | node.first : 0);
  if (node.count == 0) {
    add_thesis_node(tree, node.first, layout);
    add_thesis_node(tree, node.first + 1, layout);
  }
  layout.nodes[base + 3] = static_cast<std::uint32_t>(layout.nodes.size() / 8);
}

class ThesisEngine final : public GpuEngine {
 public:
  ThesisEngine(Device& device, bool any_hit) : GpuEngine(device, any_hit) {}
  [[nodiscard]] std::string name() const override { return "thesis"; }

  Status build(const BenchScene& scene) override {
    ZC_TRY(check_count(scene));
    const Stopwatch watch;
    const SahTree tree = build_sah_tree(scene.triangles, kThesisTree);
    Layout layout;
    layout.nodes.reserve(8 * tree.nodes.size());
    add_thesis_node(tree, 0, layout);
    layout.triangles.reserve(10 * tree.order.size());
    for (const std::uint32_t triangle : tree.order) {
      for (const float v : scene.triangles[triangle].v) layout.triangles.push_back(std::bit_cast<std::uint32_t>(v));
      layout.triangles.push_back(triangle);
    }
    figures_ = {watch.ms(), bytes_of(layout)};
    std::vector<Buffer> buffers;
    ZC_TRY(upload(device(), layout, buffers));
    KernelOptions options;
    options.spirv = shader::trace_thesis();
    return set_kernel(std::move(options), std::move(buffers));
  }
};

class Bvh2Engine final : public GpuEngine {
 public:
  Bvh2Engine(Device& device, bool any_hit) : GpuEngine(device, any_hit) {}
  [[nodiscard]] std::string name() const override { return "bvh2"; }

  Status build(const BenchScene& scene) override {
    ZC_TRY(check_count(scene));
    const Stopwatch watch;
    const SahTree tree = build_sah_tree(scene.triangles, kBvh2Tree);
    Layout layout;
    add_nodes(tree, layout);
    layout.triangles.reserve(12 * tree.order.size());
    for (const std::uint32_t triangle : tree.order) {
      const auto& v = scene.triangles[triangle].v;
      for (std::size_t corner = 0; corner < 3; ++corner) {
        for (std::size_t axis = 0; axis < 3; ++axis)
          layout.triangles.push_back(std::bit_cast<std::uint32_t>(v[3 * corner + axis]));
        layout.triangles.push_back(corner == 0 ? triangle : 0);
      }
    }
    figures_ = {watch.ms(), bytes_of(layout)};
    std::vector<Buffer> buffers;
    ZC_TRY(upload(device(), layout, buffers));
    KernelOptions options;
    options.spirv = shader::trace_bvh2();
    options.constants = {std::max(1U, tree.depth)};
    return set_kernel(std::move(options), std::move(buffers));
  }

 private:
  // A node per inner node of the tree, numbered in its order. A tree that is one leaf becomes a node with that leaf and
  // an empty one.
  static void add_nodes(const SahTree& tree, Layout& layout) {
    std::vector<std::uint32_t> number(tree.nodes.size());
    std::uint32_t inner = 0;
    for (std::size_t i = 0; i < tree.nodes.size(); ++i)
      if (tree.nodes[i].count == 0) number[i] = inner++;
    const auto ref = [&](std::uint32_t at) {
      const SahNode& node = tree.nodes[at];
      return node.count > 0 ? kLeafFlag | node.count << 27U | node.first : number[at];
    };
    layout.nodes.reserve(std::size_t{16} * std::max(inner, 1U));
    const auto add_pair = [&](const SahBox& box0, std::uint32_t ref0, const SahBox& box1, std::uint32_t ref1) {
      layout.add(box0.min);
      layout.add(box0.max);
      layout.add(box1.min);
      layout.add(box1.max);
      layout.nodes.insert(layout.nodes.end(), {ref0, ref1, 0U, 0U});
    };
    if (inner == 0) add_pair(tree.nodes[0].box, ref(0), {{1, 1, 1}, {-1, -1, -1}}, kLeafFlag);
    for (const SahNode& node : tree.nodes) {
      if (node.count > 0) continue;
      const std::uint32_t child = node.first;
      add_pair(tree.nodes[child].box, ref(child), tree.nodes[child + 1].box, ref(child + 1));
    }
  }
};

}  // namespace

std::unique_ptr<TraceEngine> make_thesis_engine(Device& device, bool any_hit) {
  return std::make_unique<ThesisEngine>(device, any_hit);
}
std::unique_ptr<TraceEngine> make_bvh2_engine(Device& device, bool any_hit) {
  return std::make_unique<Bvh2Engine>(device, any_hit);
}

}  // namespace zc::bench
