// SPDX-License-Identifier: Apache-2.0
#include "replay/bench/engines/embree_builder.h"

#ifdef ZONECAST_EMBREE
#include <embree3/rtcore.h>

#include <algorithm>
#include <limits>
#include <string>

namespace zc::bench {
namespace {

using Corners = std::array<std::array<float, 3>, 3>;

PeerBox box_of(const RTCBounds& b) { return {{b.lower_x, b.lower_y, b.lower_z}, {b.upper_x, b.upper_y, b.upper_z}}; }

// As Embree's callbacks make them; a leaf has no children.
struct RawNode {
  std::array<RawNode*, 8> children{};
  std::array<PeerBox, 8> boxes{};
  std::uint32_t child_count = 0;
  const RTCBuildPrimitive* primitives = nullptr;  // of a leaf
  std::size_t primitive_count = 0;
};

void* create_node(RTCThreadLocalAllocator allocator, unsigned /*children*/, void* /*user*/) {
  return new (rtcThreadLocalAlloc(allocator, sizeof(RawNode), alignof(RawNode))) RawNode;
}
void set_children(void* node, void** children, unsigned count, void* /*user*/) {
  auto& raw = *static_cast<RawNode*>(node);
  raw.child_count = count;
  for (unsigned i = 0; i < count; ++i) raw.children.at(i) = static_cast<RawNode*>(children[i]);
}
void set_bounds(void* node, const RTCBounds** bounds, unsigned count, void* /*user*/) {
  for (unsigned i = 0; i < count; ++i) static_cast<RawNode*>(node)->boxes.at(i) = box_of(*bounds[i]);
}
void* create_leaf(RTCThreadLocalAllocator allocator, const RTCBuildPrimitive* primitives, std::size_t count,
                  void* /*user*/) {
  auto* leaf = new (rtcThreadLocalAlloc(allocator, sizeof(RawNode), alignof(RawNode))) RawNode;
  auto* own = static_cast<RTCBuildPrimitive*>(
      rtcThreadLocalAlloc(allocator, count * sizeof(RTCBuildPrimitive), alignof(RTCBuildPrimitive)));
  std::copy_n(primitives, count, own);
  leaf->primitives = own;
  leaf->primitive_count = count;
  return leaf;
}

// The two pieces of a triangle's box at a plane, each within what was left of it.
void split_primitive(const RTCBuildPrimitive* primitive, unsigned axis, float plane, RTCBounds* left, RTCBounds* right,
                     void* user) {
  const Corners& triangle = static_cast<const Corners*>(user)[primitive->primID];
  const PeerBox whole{{primitive->lower_x, primitive->lower_y, primitive->lower_z},
                      {primitive->upper_x, primitive->upper_y, primitive->upper_z}};
  std::array<PeerBox, 2> sides;
  const auto grow = [](PeerBox& box, const std::array<float, 3>& p) {
    for (std::size_t i = 0; i < 3; ++i) {
      box.min[i] = std::min(box.min[i], p[i]);
      box.max[i] = std::max(box.max[i], p[i]);
    }
  };
  for (PeerBox& side : sides) {
    side.min.fill(std::numeric_limits<float>::infinity());
    side.max.fill(-std::numeric_limits<float>::infinity());
  }
  for (std::size_t i = 0; i < 3; ++i) {
    const std::array<float, 3>& from = triangle[i];
    const std::array<float, 3>& to = triangle[(i + 1) % 3];
    if (from[axis] <= plane) grow(sides[0], from);
    if (from[axis] >= plane) grow(sides[1], from);
    if ((from[axis] < plane) == (to[axis] < plane) || from[axis] == plane || to[axis] == plane) continue;
    const float part = (plane - from[axis]) / (to[axis] - from[axis]);
    std::array<float, 3> p{};
    for (std::size_t k = 0; k < 3; ++k) p[k] = from[k] + part * (to[k] - from[k]);
    p[axis] = plane;
    grow(sides[0], p);
    grow(sides[1], p);
  }
  const auto write = [&](PeerBox box, RTCBounds& out) {
    for (std::size_t i = 0; i < 3; ++i) {
      box.min[i] = std::max(box.min[i], whole.min[i]);
      box.max[i] = std::min(box.max[i], whole.max[i]);
    }
    out.lower_x = box.min[0], out.lower_y = box.min[1], out.lower_z = box.min[2];
    out.upper_x = box.max[0], out.upper_y = box.max[1], out.upper_z = box.max[2];
  };
  write(sides[0], *left);
  write(sides[1], *right);
}

std::uint32_t flatten(const RawNode& raw, std::vector<PeerNode>& nodes) {
  const auto index = static_cast<std::uint32_t>(nodes.size());
  nodes.emplace_back();
  nodes[index].child_count = raw.child_count;
  nodes[index].boxes = raw.boxes;
  for (std::size_t i = 0; i < raw.primitive_count; ++i) {
    const RTCBuildPrimitive& p = raw.primitives[i];
    nodes[index].references.push_back(
        {{{p.lower_x, p.lower_y, p.lower_z}, {p.upper_x, p.upper_y, p.upper_z}}, p.primID});
  }
  for (std::uint32_t i = 0; i < raw.child_count; ++i) {
    const std::uint32_t child = flatten(*raw.children[i], nodes);
    nodes[index].children[i] = child;
  }
  return index;
}

class Tree final : public EmbreeTree {
 public:
  Tree(RTCBVH bvh, const RawNode* root) : bvh_(bvh), root_(root) {}
  Tree(const Tree&) = delete;
  Tree& operator=(const Tree&) = delete;
  ~Tree() override { rtcReleaseBVH(bvh_); }
  [[nodiscard]] std::vector<PeerNode> nodes() const override {
    std::vector<PeerNode> nodes;
    flatten(*root_, nodes);
    return nodes;
  }

 private:
  RTCBVH bvh_;
  const RawNode* root_;
};

class Builder final : public EmbreeBuilder {
 public:
  explicit Builder(unsigned threads) {
    const std::string config = "threads=" + std::to_string(threads);
    device_ = rtcNewDevice(config.c_str());
  }
  Builder(const Builder&) = delete;
  Builder& operator=(const Builder&) = delete;
  ~Builder() override {
    if (device_ != nullptr) rtcReleaseDevice(device_);
  }

  Result<std::unique_ptr<EmbreeTree>> build(std::span<const Corners> triangles, const EmbreeOptions& options) override {
    std::vector<RTCBuildPrimitive> primitives(triangles.size());
    for (std::size_t i = 0; i < triangles.size(); ++i) {
      const Corners& t = triangles[i];
      const auto low = [&](std::size_t axis) { return std::min({t[0][axis], t[1][axis], t[2][axis]}); };
      const auto high = [&](std::size_t axis) { return std::max({t[0][axis], t[1][axis], t[2][axis]}); };
      primitives[i] = {low(0), low(1), low(2), 0, high(0), high(1), high(2), static_cast<unsigned>(i)};
    }
    const bool splits = options.quality == EmbreeQuality::kSplits;
    if (splits) primitives.resize(2 * triangles.size());  // room for pieces
    RTCBuildArguments arguments = rtcDefaultBuildArguments();
    arguments.buildQuality = splits                                   ? RTC_BUILD_QUALITY_HIGH
                             : options.quality == EmbreeQuality::kSah ? RTC_BUILD_QUALITY_MEDIUM
                                                                      : RTC_BUILD_QUALITY_LOW;
    arguments.maxBranchingFactor = options.width;
    arguments.maxDepth = 64;
    arguments.maxLeafSize = options.leaf_triangles;
    arguments.primitives = primitives.data();
    arguments.primitiveCount = triangles.size();
    arguments.primitiveArrayCapacity = primitives.size();
    arguments.createNode = create_node;
    arguments.setNodeChildren = set_children;
    arguments.setNodeBounds = set_bounds;
    arguments.createLeaf = create_leaf;
    arguments.splitPrimitive = splits ? split_primitive : nullptr;
    arguments.userPtr = const_cast<Corners*>(triangles.data());  // callbacks only read it
    arguments.bvh = rtcNewBVH(device_);
    const auto* root = static_cast<const RawNode*>(rtcBuildBVH(&arguments));
    std::unique_ptr<EmbreeTree> tree = std::make_unique<Tree>(arguments.bvh, root);
    if (root == nullptr)
      return Error{ErrorCode::kDevice,
                   "rtcBuildBVH failed with RTCError " + std::to_string(rtcGetDeviceError(device_))};
    return tree;
  }

 private:
  RTCDevice device_ = nullptr;
};

}  // namespace

std::unique_ptr<EmbreeBuilder> make_embree_builder(unsigned threads) { return std::make_unique<Builder>(threads); }

}  // namespace zc::bench
#else
namespace zc::bench {

std::unique_ptr<EmbreeBuilder> make_embree_builder(unsigned /*threads*/) { return nullptr; }

}  // namespace zc::bench
#endif
