// SPDX-License-Identifier: Apache-2.0
// verify_page: after it, a traversal with a stack for the page's depth stays in the page and ends.
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <vector>

#include "shaders/shared/page_node.h"
#include "streamer/world_format/bvh_page.h"
#include "streamer/world_format/page_view.h"

namespace zc {
namespace {

class PageCheck {
 public:
  PageCheck(std::span<const std::uint32_t> page, std::uint32_t material_count, const std::string& path)
      : page_(page), material_count_(material_count), path_(path) {}

  Status run() {
    ZC_TRY(check_header());
    ZC_TRY(check_clusters());
    depth_.assign(header_.node_count, 0);
    position_seen_.assign(header_.triangle_count, false);
    depth_[0] = 1;
    std::uint32_t positions = 0;
    std::uint32_t deepest = 0;
    for (std::uint32_t i = 0; i < header_.node_count; ++i) {
      const gpu::PageNode node = view_->node(i);
      if (depth_[i] == 0) return fault("a node is not part of the tree", PageView::node_word(i));
      deepest = std::max<std::uint32_t>(deepest, depth_[i]);
      ZC_TRY(check_slots(i, node));
      ZC_TRY(check_children(i, node));
      ZC_TRY(check_leaves(i, node, positions));
    }
    if (deepest != header_.depth)
      return fault("depth differs from its header", kWord(offsetof(gpu::PageHeader, depth)));
    if (positions != header_.triangle_count) return fault("a triangle is in no leaf", header_.entries_offset_words);
    return {};
  }

 private:
  static constexpr std::size_t kWord(std::size_t byte) { return byte / sizeof(std::uint32_t); }

  static constexpr std::uint32_t kClusterUnusedBits =
      ((1U << gpu::kClusterShiftBit) - 1) & ~((1U << (gpu::kClusterVertexBits + gpu::kClusterTriangleBits)) - 1) &
      ~(gpu::kClusterLight | gpu::kClusterNormals | gpu::kClusterAppearances);

  [[nodiscard]] bool has_appearances() const { return (header_.flags & gpu::kPageAppearances) != 0; }

  [[nodiscard]] Error fault(const char* cause, std::size_t word) const {
    return {ErrorCode::kFormat, std::string("page: ") + cause + " (word " + std::to_string(word) + ")", path_};
  }

  Status check_header() {
    if (page_.size() < gpu::kPageHeaderWords || page_.size() > UINT32_MAX) return fault("size out of range", 0);
    view_.emplace(page_);
    header_ = view_->header();
    const gpu::PageHeader& h = header_;
    if (h.magic != gpu::kPageMagic) return fault("wrong magic", 0);
    if ((h.flags & ~gpu::kPageFlags) != 0) return fault("unknown flags", 1);
    if (h.node_count == 0 || h.node_count > gpu::kPageMaxNodes) return fault("node count out of range", 2);
    if (h.triangle_count == 0 || h.triangle_count > gpu::kPageMaxTriangles)
      return fault("triangle count out of range", 3);
    if (h.cluster_count == 0 || h.cluster_count > h.triangle_count) return fault("cluster count out of range", 4);
    if (h.depth == 0 || h.depth > gpu::kPageMaxDepth) return fault("depth out of range", 8);
    for (std::size_t word = gpu::kPageAtlasWord + 3; word < gpu::kPageHeaderWords; ++word)
      if (page_[word] != 0) return fault("a reserved word is not zero", word);
    clusters_word_ = PageView::node_word(h.node_count);
    const std::uint64_t palette_words =
        has_appearances() ? 2 * std::uint64_t{h.palette_count} : (std::uint64_t{h.palette_count} + 1) / 2;
    std::uint64_t end = h.palette_offset_words + palette_words;
    if (h.atlas_offset_words != 0) {
      const AtlasShape atlas = AtlasShape::unpack(h.atlas_size);
      if (!has_appearances() || h.atlas_offset_words != end || !atlas.valid() || !std::isfinite(h.texels_per_step))
        return fault("the atlas is not where it belongs", gpu::kPageAtlasWord);
      end += atlas.words();
    } else if (h.atlas_size != 0 || page_[gpu::kPageAtlasWord + 2] != 0) {
      return fault("an atlas that is not there has a size", gpu::kPageAtlasWord + 1);
    }
    if (h.entries_offset_words < clusters_word_ ||
        h.palette_offset_words != h.entries_offset_words + std::uint64_t{gpu::kClusterEntryWords} * h.cluster_count ||
        h.palette_count == 0)
      return fault("a part is not where it belongs", 5);
    if (h.total_words != page_.size() || page_.size() % gpu::kPageAlignWords != 0 || end > page_.size() ||
        page_.size() - end >= gpu::kPageAlignWords)
      return fault("size does not follow from its counts", 9);
    return {};
  }

  Status check_clusters() {
    std::uint64_t at = clusters_word_;
    std::uint64_t position = 0;
    for (std::uint32_t c = 0; c < header_.cluster_count; ++c) {
      const gpu::ClusterEntry entry = view_->entry(c);
      if (entry.offset_words != at || entry.first_triangle != position)
        return fault("a cluster's entry is wrong", header_.entries_offset_words + gpu::kClusterEntryWords * c);
      if (at + gpu::kClusterHeaderWords > header_.entries_offset_words) return fault("cluster out of range", at);
      const auto cluster = page_record<gpu::ClusterHeader>(page_, at);
      const std::uint64_t triangles = cluster_triangles(cluster);
      const std::uint64_t vertices = cluster_vertices(cluster);
      const std::uint32_t flags = cluster.counts & (gpu::kClusterLight | gpu::kClusterNormals);
      const std::uint64_t words = cluster_parts(vertices, triangles, flags).words;
      if ((cluster.counts & kClusterUnusedBits) != 0 ||
          ((cluster.counts & gpu::kClusterAppearances) != 0) != has_appearances() ||
          ((flags & gpu::kClusterLight) != 0) != ((header_.flags & gpu::kPageLight) != 0) ||
          ((flags & gpu::kClusterNormals) != 0 && (header_.flags & gpu::kPageNormals) == 0))
        return fault("a cluster's flags are wrong", at + 3);
      if (triangles == 0 || triangles > gpu::kClusterMaxTriangles || vertices == 0 ||
          vertices > gpu::kClusterMaxVertices || at + words > header_.entries_offset_words)
        return fault("cluster out of range", at);
      if (!std::isfinite(cluster.error_m) || cluster.error_m < 0)
        return fault("an error bound is not a number", at + 4);
      if (cluster.page_back_words != at || cluster.first_triangle != position)
        return fault("a cluster does not know its place", at + 5);
      const std::uint64_t palette = at + cluster.palette_words;
      if (palette < header_.palette_offset_words) return fault("palette out of range", at + 7);
      if (has_appearances() && (palette - header_.palette_offset_words) % 2 != 0)
        return fault("palette out of place", at + 7);
      const std::uint64_t first = has_appearances() ? (palette - header_.palette_offset_words) / 2
                                                    : 2 * (palette - header_.palette_offset_words);
      for (std::uint64_t t = 0; t < triangles; ++t) {
        const std::size_t word = at + gpu::kClusterHeaderWords + t;
        const std::uint32_t packed = page_[word];
        const std::uint32_t most = std::max({packed & 0xFFU, packed >> 8 & 0xFFU, packed >> 16 & 0xFFU});
        if (most >= vertices) return fault("a triangle's vertex out of range", word);
        const std::uint64_t place = first + (packed >> 24);
        if (place >= header_.palette_count) return fault("a triangle's material out of the palette", word);
      }
      at += words;
      position += triangles;
    }
    if (at != header_.entries_offset_words) return fault("the clusters do not end where the entries begin", at);
    if (position != header_.triangle_count) return fault("the clusters have another number of triangles", 3);
    return check_palette();
  }

  Status check_palette() const {
    for (std::uint32_t i = 0; i < header_.palette_count; ++i) {
      const std::size_t word = header_.palette_offset_words + (has_appearances() ? 2 * i : i / 2);
      const std::uint32_t material =
          has_appearances() ? page_[word] & 0xFFFFU : page_[word] >> (16 * (i % 2)) & 0xFFFFU;
      if (material >= material_count_) return fault("material out of range", word);
      if (!has_appearances()) continue;
      const std::uint32_t kind = page_[word] >> 16 & 3U;
      if (kind > gpu::kAppearanceTextured || page_[word] >> 31 != 0)
        return fault("an appearance of unknown kind", word);
      if (kind == gpu::kAppearanceTextured && (header_.atlas_offset_words == 0 || (page_[word] >> 18 & 3U) > 2))
        return fault("an appearance without its atlas", word);
    }
    return {};
  }

  // Masks, counts and boxes of the slots, taken alone.
  Status check_slots(std::uint32_t i, const gpu::PageNode& node) const {
    const std::size_t word = PageView::node_word(i);
    const std::uint32_t inner = inner_mask(node);
    const std::uint32_t leaves = leaf_mask(node);
    if ((inner & leaves) != 0 || (inner | leaves) == 0 || (node.exponents_masks >> 15U & 1U) != 0)
      return fault("a node's masks are wrong", word + 3);
    const std::array<std::uint32_t, 12> planes = node_planes(node);
    std::uint32_t triangles = 0;
    for (std::uint32_t slot = 0; slot < gpu::kNodeWidth; ++slot) {
      const bool used = ((inner | leaves) >> slot & 1U) != 0;
      const std::uint32_t count = leaf_count(node, slot);
      if ((leaves >> slot & 1U) != 0 ? count == 0 || count > gpu::kLeafMaxTriangles : count != 0)
        return fault("a leaf's size is out of range", word + 6);
      triangles += count;
      if (used && !on_lattice(child_box(node, slot))) return fault("a box leaves the lattice", word + 3);
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const std::uint32_t low = planes[2 * axis + slot / 4] >> (8 * (slot & 3U)) & 0xFFU;
        const std::uint32_t high = planes[6 + 2 * axis + slot / 4] >> (8 * (slot & 3U)) & 0xFFU;
        if (used ? low > high : low != 255 || high != 0) return fault("a slot's box is wrong", word + 8);
      }
    }
    if (triangles > gpu::kNodeMaxTriangles) return fault("a node has too many triangles", word + 6);
    return {};
  }

  // Children lie behind their parent and have no other, so that a visit in order reaches every node after its parent.
  Status check_children(std::uint32_t i, const gpu::PageNode& node) {
    const std::size_t word = PageView::node_word(i);
    const std::uint32_t inner = inner_mask(node);
    if (inner == 0)
      return node.child_offset == 0 ? Status{} : Status{fault("a node has children without a slot", word + 4)};
    std::uint64_t child = std::uint64_t{i} + node.child_offset / gpu::kPageNodeWords;
    if (node.child_offset == 0 || node.child_offset % gpu::kPageNodeWords != 0)
      return fault("child out of place", word + 4);
    for (std::uint32_t slot = 0; slot < gpu::kNodeWidth; ++slot) {
      if ((inner >> slot & 1U) == 0) continue;
      if (child >= header_.node_count) return fault("child out of range", word + 4);
      if (depth_[child] != 0) return fault("a node has two parents", word + 4);
      if (depth_[i] == header_.depth) return fault("deeper than its header says", word + 4);
      depth_[child] = static_cast<std::uint8_t>(depth_[i] + 1);
      const WideNodeBox outer = child_box(node, slot);
      const gpu::PageNode below = view_->node(static_cast<std::uint32_t>(child));
      const std::uint32_t used = inner_mask(below) | leaf_mask(below);
      for (std::uint32_t s = 0; s < gpu::kNodeWidth; ++s)
        if ((used >> s & 1U) != 0 && !contains(outer, child_box(below, s)))
          return fault("a box does not contain its children", word);
      ++child;
    }
    return {};
  }

  Status check_leaves(std::uint32_t i, const gpu::PageNode& node, std::uint32_t& positions) {
    const std::size_t word = PageView::node_word(i);
    const std::uint32_t leaves = leaf_mask(node);
    if (leaves == 0)
      return node.triangle_offset == 0 && node.cluster_offset == 0
                 ? Status{}
                 : Status{fault("a node has triangles without a leaf", word + 5)};
    const std::uint64_t at = word + std::uint64_t{node.cluster_offset};
    const std::optional<std::uint32_t> found = find_cluster(at);
    if (!found) return fault("cluster out of place", word + 7);
    const auto cluster = page_record<gpu::ClusterHeader>(page_, at);
    const std::uint64_t first_word = word + std::uint64_t{node.triangle_offset};
    const std::uint64_t begin = at + gpu::kClusterHeaderWords;
    std::uint64_t count = 0;
    for (std::uint32_t slot = 0; slot < gpu::kNodeWidth; ++slot) count += leaf_count(node, slot);
    if (first_word < begin || first_word + count > begin + cluster_triangles(cluster))
      return fault("triangles out of their cluster", word + 5);

    const auto first = static_cast<std::uint32_t>(cluster.first_triangle + (first_word - begin));
    const std::size_t vertices = begin + cluster_triangles(cluster);
    std::uint32_t position = first;
    for (std::uint32_t slot = 0; slot < gpu::kNodeWidth; ++slot) {
      if ((leaves >> slot & 1U) == 0) continue;
      const WideNodeBox box = child_box(node, slot);
      for (std::uint32_t k = leaf_count(node, slot); k > 0; --k, ++position) {
        if (position_seen_[position]) return fault("a triangle is in two leaves", first_word + position - first);
        position_seen_[position] = true;
        ++positions;
        const WideNodeBox content = bounds(cluster, page_[first_word + position - first], vertices);
        if (!on_lattice(content)) return fault("a triangle leaves the lattice", first_word + position - first);
        if ((header_.flags & gpu::kPageSplitTriangles) != 0 ? !overlaps(box, content) : !contains(box, content))
          return fault("a box does not contain its triangles", word);
      }
    }
    return {};
  }

  [[nodiscard]] std::optional<std::uint32_t> find_cluster(std::uint64_t word) const {
    std::uint32_t low = 0;
    for (std::uint32_t count = header_.cluster_count; count > 1;) {
      const std::uint32_t half = count / 2;
      if (view_->entry(low + half).offset_words <= word) low += half;
      count -= half;
    }
    if (view_->entry(low).offset_words != word) return {};
    return low;
  }

  [[nodiscard]] WideNodeBox bounds(const gpu::ClusterHeader& cluster, std::uint32_t packed,
                                   std::size_t vertices) const {
    const std::array<std::int64_t, 3> origin = {cluster.origin_x, cluster.origin_y, cluster.origin_z};
    WideNodeBox box{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      std::uint32_t low = 0xFFFF;
      std::uint32_t high = 0;
      for (std::uint32_t k = 0; k < 3; ++k) {
        const std::size_t half = 3 * std::size_t{packed >> (8 * k) & 0xFFU} + axis;
        const std::uint32_t value = page_[vertices + half / 2] >> (16 * (half % 2)) & 0xFFFFU;
        low = std::min(low, value);
        high = std::max(high, value);
      }
      box.min[axis] = origin[axis] + (std::int64_t{low} << cluster_shift(cluster));
      box.max[axis] = origin[axis] + (std::int64_t{high} << cluster_shift(cluster));
    }
    return box;
  }

  // Beyond it 32-bit coordinates wrap round: what is there would vanish from the top level. Origins are inside, and all
  // that counts from them counts upwards.
  static bool on_lattice(const WideNodeBox& box) {
    return std::ranges::all_of(box.max, [](std::int64_t v) { return v <= INT32_MAX; });
  }
  static bool contains(const WideNodeBox& outer, const WideNodeBox& inner) {
    for (std::size_t axis = 0; axis < 3; ++axis)
      if (inner.min[axis] < outer.min[axis] || inner.max[axis] > outer.max[axis]) return false;
    return true;
  }
  static bool overlaps(const WideNodeBox& a, const WideNodeBox& b) {
    for (std::size_t axis = 0; axis < 3; ++axis)
      if (b.max[axis] < a.min[axis] || b.min[axis] > a.max[axis]) return false;
    return true;
  }

  std::span<const std::uint32_t> page_;
  std::uint32_t material_count_;
  const std::string& path_;
  std::optional<PageView> view_;
  gpu::PageHeader header_ = {};
  std::size_t clusters_word_ = 0;
  std::vector<std::uint8_t> depth_;  // 0: not reached yet
  std::vector<bool> position_seen_;
};

}  // namespace

Status verify_page(std::span<const std::uint32_t> page, std::uint32_t material_count, const std::string& path) {
  return PageCheck(page, material_count, path).run();
}

}  // namespace zc
