// SPDX-License-Identifier: Apache-2.0
// assemble_page: the decoded mesh's triangles go into the clusters that the BVH file asks for.
#include <algorithm>
#include <cstring>

#include "shaders/shared/page_node.h"
#include "streamer/world_format/bvh_page.h"
#include "streamer/world_format/cluster_tables.h"
#include "streamer/world_format/leaf_boxes.h"
#include "streamer/world_format/page_view.h"

namespace zc {
namespace {

class PageAssembly {
 public:
  PageAssembly(const ZoneMesh& mesh, const BvhFile& bvh, const NodeRecord& node, const std::string& path)
      : mesh_(mesh), bvh_(bvh), appearance_(bvh.appearance), node_(node), path_(path) {}

  Result<std::vector<std::uint32_t>> run() {
    ZC_TRY(check_order());
    ZC_TRY(check_appearance());
    flags_ = (bvh_.split ? gpu::kPageSplitTriangles : 0) | appearance_.page_flags();
    page_.reserve(node_.page_bytes / 4);
    page_.resize(gpu::kPageHeaderWords + bvh_.nodes.size() * gpu::kPageNodeWords);
    std::vector<std::uint32_t> cluster_at(bvh_.clusters.size());
    std::vector<std::uint32_t> window(bvh_.clusters.size());
    for (std::uint32_t c = 0; c < cluster_at.size(); ++c) {
      cluster_at[c] = words();
      ZC_TRY(append_cluster(c, window[c]));
    }
    close_window();
    gpu::PageHeader header{};
    header.magic = gpu::kPageMagic;
    header.flags = flags_;
    header.node_count = static_cast<std::uint32_t>(bvh_.nodes.size());
    header.triangle_count = static_cast<std::uint32_t>(bvh_.order.size());
    header.cluster_count = static_cast<std::uint32_t>(cluster_at.size());
    header.depth = bvh_.depth;
    header.entries_offset_words = words();
    for (std::size_t c = 0; c < cluster_at.size(); ++c) page_.insert(page_.end(), {bvh_.clusters[c], cluster_at[c]});
    header.palette_offset_words = words();
    header.palette_count = static_cast<std::uint32_t>(palette_.size());
    append_palette();
    if (!appearance_.atlas.empty()) {
      header.atlas_offset_words = words();
      header.atlas_size = appearance_.atlas_size;
      header.texels_per_step = appearance_.texels_per_step;
      page_.insert(page_.end(), appearance_.atlas.begin(), appearance_.atlas.end());
    }
    align();
    header.total_words = words();
    std::memcpy(page_.data(), &header, sizeof header);
    for (std::size_t c = 0; c < cluster_at.size(); ++c)
      page_[cluster_at[c] + offsetof(gpu::ClusterHeader, palette_words) / 4] =
          header.palette_offset_words + (has_appearances() ? 2 * window[c] : window[c] / 2) - cluster_at[c];
    ZC_TRY(place_nodes(cluster_at));
    return std::move(page_);
  }

 private:
  [[nodiscard]] Error fault(const char* cause) const { return {ErrorCode::kFormat, cause, path_}; }
  [[nodiscard]] std::uint32_t words() const { return static_cast<std::uint32_t>(page_.size()); }

  void align() {
    while (page_.size() % gpu::kPageAlignWords != 0) page_.push_back(0);
  }

  template <class Halves>
  void append_halves(const Halves& values) {
    const std::size_t at = page_.size();
    page_.resize(at + (values.size() + 1) / 2);
    for (std::size_t i = 0; i < values.size(); ++i)
      page_[at + i / 2] |= static_cast<std::uint32_t>(values[i]) << (16 * (i % 2));
  }

  [[nodiscard]] bool has_appearances() const { return !appearance_.appearances.empty(); }

  // What a triangle's place in the palette stands for.
  [[nodiscard]] std::uint16_t palette_entry(std::uint32_t triangle) const {
    return has_appearances() ? appearance_.appearance_of[triangle] : mesh_.materials[triangle];
  }

  void append_palette() {
    if (!has_appearances()) return append_halves(palette_);
    for (const std::uint16_t entry : palette_)
      page_.insert(page_.end(), {appearance_.appearances[entry].material, appearance_.appearances[entry].place});
  }

  // Every part is there for all triangles or for none, and says of a triangle's material what the mesh says.
  Status check_appearance() const {
    const std::size_t triangles = mesh_.triangles.size();
    if (appearance_.appearance_of.size() != (has_appearances() ? triangles : 0))
      return fault("not every triangle has an appearance");
    for (std::size_t t = 0; t < appearance_.appearance_of.size(); ++t) {
      if (appearance_.appearance_of[t] >= appearance_.appearances.size())
        return fault("a triangle's appearance is out of range");
      if ((appearance_.appearances[appearance_.appearance_of[t]].material & 0xFFFFU) != mesh_.materials[t])
        return fault("a triangle's appearance has another material");
    }
    if (!appearance_.light.empty() && appearance_.light.size() != triangles)
      return fault("not every triangle has light");
    if (appearance_.normals.size() != appearance_.curved.size())
      return fault("curved triangles and normals differ in number");
    for (std::size_t i = 0; i < appearance_.curved.size(); ++i)
      if (appearance_.curved[i] >= triangles || (i > 0 && appearance_.curved[i] <= appearance_.curved[i - 1]))
        return fault("the curved triangles are not in order");
    return {};
  }

  [[nodiscard]] gpu::TriangleNormals normals_of(std::uint32_t triangle) const {
    const auto found = std::ranges::lower_bound(appearance_.curved, triangle);
    if (found == appearance_.curved.end() || *found != triangle) return {};
    return appearance_.normals[static_cast<std::size_t>(found - appearance_.curved.begin())];
  }

  // Every triangle has a place, and more than one only where the file says so.
  Status check_order() const {
    std::vector<bool> seen(mesh_.triangles.size());
    std::size_t missing = seen.size();
    for (const std::uint32_t triangle : bvh_.order) {
      if (triangle >= seen.size()) return fault("the triangle order leaves the mesh");
      if (seen[triangle] && !bvh_.split) return fault("a triangle comes twice");
      missing -= seen[triangle] ? 0 : 1;
      seen[triangle] = true;
    }
    if (missing > 0) return fault("a triangle of the mesh is in no leaf");
    for (const auto& triangle : mesh_.triangles)
      for (const std::uint32_t corner : triangle)
        if (corner >= mesh_.vertices.size()) return fault("a triangle leaves the mesh");
    return {};
  }

  // Clusters share windows of the palette as long as 256 entries last.
  void close_window() {
    palette_.insert(palette_.end(), entries_.entries().begin(), entries_.entries().end());
    if (palette_.size() % 2 != 0) palette_.push_back(palette_.back());
    entries_.clear();
  }

  Status append_cluster(std::uint32_t c, std::uint32_t& window) {
    const std::size_t first = bvh_.clusters[c];
    const std::size_t end = c + 1 < bvh_.clusters.size() ? bvh_.clusters[c + 1] : bvh_.order.size();
    const auto all_fit = [&] {
      return std::all_of(bvh_.order.begin() + static_cast<std::ptrdiff_t>(first),
                         bvh_.order.begin() + static_cast<std::ptrdiff_t>(end),
                         [&](std::uint32_t t) { return entries_.add(palette_entry(t)).has_value(); });
    };
    ClusterPalette before = entries_;
    if (!all_fit()) {
      entries_ = std::move(before);
      close_window();
      if (!all_fit()) return fault("a cluster has more than 256 materials or appearances");
    }
    window = static_cast<std::uint32_t>(palette_.size());

    const std::size_t at = page_.size();
    page_.resize(at + gpu::kClusterHeaderWords);
    vertices_.clear();
    for (std::size_t i = first; i < end; ++i) {
      const std::uint32_t triangle = bvh_.order[i];
      std::uint32_t word = *entries_.add(palette_entry(triangle)) << 24;
      for (std::size_t k = 0; k < 3; ++k) {
        const auto number = vertices_.add(mesh_.vertices[mesh_.triangles[triangle][k]]);
        if (!number) return fault("a cluster has more than 256 vertices");
        word |= *number << (8 * k);
      }
      page_.push_back(word);
    }
    for (const ClusterVertices::Vertex& v : vertices_.vertices()) flat_.insert(flat_.end(), v.begin(), v.end());
    append_halves(flat_);
    flat_.clear();
    const std::uint32_t flags = append_attributes(first, end);
    align();
    gpu::ClusterHeader header{};
    header.origin_x = node_.origin[0];
    header.origin_y = node_.origin[1];
    header.origin_z = node_.origin[2];
    if (end - first > gpu::kClusterMaxTriangles) return fault("a cluster has too many triangles");
    header.counts = static_cast<std::uint32_t>(vertices_.vertices().size()) |
                    static_cast<std::uint32_t>(end - first) << gpu::kClusterVertexBits | flags |
                    node_.step_shift << gpu::kClusterShiftBit;
    header.error_m = node_.error_max_m;
    header.page_back_words = static_cast<std::uint32_t>(at);
    header.first_triangle = static_cast<std::uint32_t>(first);
    std::memcpy(page_.data() + at, &header, sizeof header);
    return {};
  }

  // Light and normals of a cluster's triangles; returns its flags.
  std::uint32_t append_attributes(std::size_t first, std::size_t end) {
    std::uint32_t flags = has_appearances() ? gpu::kClusterAppearances : 0;
    const std::span<const std::uint32_t> triangles(bvh_.order.data() + first, end - first);
    const auto start = [&](std::uint32_t flag) {
      flags |= flag;
      if (page_.size() % 2 != 0) page_.push_back(0);
    };
    if (!appearance_.light.empty()) {
      start(gpu::kClusterLight);
      for (const std::uint32_t t : triangles)
        page_.insert(page_.end(), {appearance_.light[t].sky, appearance_.light[t].bounce});
    }
    const auto is_curved = [&](std::uint32_t t) { return std::ranges::binary_search(appearance_.curved, t); };
    if (std::ranges::any_of(triangles, is_curved)) {
      start(gpu::kClusterNormals);
      for (const std::uint32_t t : triangles) {
        const gpu::TriangleNormals n = normals_of(t);
        page_.insert(page_.end(), {n.first_second, n.second_third});
      }
    }
    return flags;
  }

  // From numbers in the file to distances in words.
  Status place_nodes(const std::vector<std::uint32_t>& cluster_at) {
    for (std::uint32_t i = 0; i < bvh_.nodes.size(); ++i) {
      gpu::PageNode node = bvh_.nodes[i];
      const auto at = static_cast<std::uint32_t>(PageView::node_word(i));
      if (inner_mask(node) != 0) {
        if (node.child_offset <= i || node.child_offset >= bvh_.nodes.size())
          return fault("a node's children are out of range");
        node.child_offset = (node.child_offset - i) * gpu::kPageNodeWords;
      } else if (node.child_offset != 0) {
        return fault("a node has children that it does not name");
      }
      if (leaf_mask(node) != 0) {
        const std::uint32_t c = node.cluster_offset;
        if (c >= cluster_at.size() || node.triangle_offset < bvh_.clusters[c] ||
            node.triangle_offset >= bvh_.order.size())
          return fault("a node's triangles are out of range");
        node.triangle_offset = cluster_at[c] + gpu::kClusterHeaderWords + node.triangle_offset - bvh_.clusters[c] - at;
        node.cluster_offset = cluster_at[c] - at;
      } else if (node.triangle_offset != 0 || node.cluster_offset != 0) {
        return fault("a node has triangles that it does not name");
      }
      std::memcpy(page_.data() + at, &node, sizeof node);
    }
    return {};
  }

  const ZoneMesh& mesh_;
  const BvhFile& bvh_;
  const ZoneAppearance& appearance_;
  const NodeRecord& node_;
  const std::string& path_;
  std::uint32_t flags_ = 0;
  std::vector<std::uint32_t> page_;
  std::vector<std::uint16_t> palette_;  // materials, or appearances
  ClusterPalette entries_;
  ClusterVertices vertices_;
  std::vector<std::uint16_t> flat_;
};

NodeBox box_of_slot(const gpu::PageNode& node, std::uint32_t slot) {
  const WideNodeBox wide = child_box(node, slot);
  NodeBox box;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    box.min[axis] = static_cast<std::int32_t>(wide.min[axis]);
    box.max[axis] = static_cast<std::int32_t>(std::min<std::int64_t>(wide.max[axis], INT32_MAX));
  }
  return box;
}

// The triangles that come more than once, ascending.
std::vector<PieceOfTriangle> triangles_in_pieces(const BvhFile& bvh, std::size_t triangles) {
  std::vector<PieceOfTriangle> pieces;
  pieces.reserve(bvh.order.size() - std::min(bvh.order.size(), triangles));
  std::vector<bool> seen(triangles);
  for (const std::uint32_t triangle : bvh.order) {
    if (seen[triangle]) pieces.push_back({triangle, {}});
    seen[triangle] = true;
  }
  std::ranges::sort(pieces, {}, &PieceOfTriangle::triangle);
  const auto same = [](const PieceOfTriangle& a, const PieceOfTriangle& b) { return a.triangle == b.triangle; };
  pieces.erase(std::unique(pieces.begin(), pieces.end(), same), pieces.end());
  return pieces;
}

// verify_page cannot ask of one piece of a split triangle that its box contains it all; together they must.
Status check_split_boxes(std::span<const std::uint32_t> page, const BvhFile& bvh, std::size_t triangles,
                         const std::string& path) {
  const PageView view(page);
  const auto contains = [&](const NodeBox& box, std::uint32_t position) {
    return std::ranges::all_of(view.triangle(position).corners, [&](const PageView::Point& corner) {
      for (std::size_t axis = 0; axis < 3; ++axis)
        if (corner[axis] < box.min[axis] || corner[axis] > box.max[axis]) return false;
      return true;
    });
  };
  std::vector<PieceOfTriangle> pieces = triangles_in_pieces(bvh, triangles);
  const auto piece_of = [&](std::uint32_t at) {
    const auto found = std::ranges::lower_bound(pieces, bvh.order[at], {}, &PieceOfTriangle::triangle);
    return found != pieces.end() && found->triangle == bvh.order[at] ? &*found : nullptr;
  };
  const Error fault{ErrorCode::kFormat, "the pieces of a triangle do not make it up", path};
  for (std::uint32_t i = 0; i < view.header().node_count; ++i) {
    const gpu::PageNode node = view.node(i);
    if (leaf_mask(node) == 0) continue;
    std::uint32_t at = view.first_triangle(i);
    for (std::uint32_t slot = 0; slot < gpu::kNodeWidth; ++slot) {
      const NodeBox box = box_of_slot(node, slot);
      for (std::uint32_t k = leaf_count(node, slot); k > 0; --k, ++at) {
        if (PieceOfTriangle* piece = piece_of(at))
          piece->box.add(box);
        else if (!contains(box, at))
          return fault;
      }
    }
  }
  for (std::uint32_t at = 0; at < bvh.order.size(); ++at)
    if (const PieceOfTriangle* piece = piece_of(at); piece != nullptr && !contains(piece->box, at)) return fault;
  return {};
}

}  // namespace

Result<std::vector<std::uint32_t>> assemble_page(const ZoneMesh& mesh, const BvhFile& bvh, const NodeRecord& node,
                                                 std::uint32_t material_count, const std::string& path) {
  if (bvh.nodes.size() != node.bvh_node_count || bvh.depth != node.bvh_depth ||
      bvh.order.size() != node.reference_count || bvh.clusters.empty())
    return Error{ErrorCode::kFormat, "the BVH is not the one that the index describes", path};
  if (mesh.triangles.size() != node.triangle_count || mesh.materials.size() != node.triangle_count)
    return Error{ErrorCode::kFormat, "mesh and index disagree on the number of triangles", path};
  ZC_ASSIGN(std::vector<std::uint32_t> page, PageAssembly(mesh, bvh, node, path).run());
  if (node.page_bytes != 0 && node.page_bytes != 4 * page.size())
    return Error{ErrorCode::kFormat, "the page is not as large as the index says", path};
  ZC_TRY(verify_page(page, material_count, path));
  const PageView::Parts expected = {node.appearance_bytes, node.light_bytes, node.normal_bytes, node.texture_bytes};
  if (node.page_bytes != 0 && PageView(page).parts() != expected)
    return Error{ErrorCode::kFormat, "the page has other appearances than the index says", path};
  if (bvh.split) ZC_TRY(check_split_boxes(page, bvh, mesh.triangles.size(), path));
  return page;
}

}  // namespace zc
