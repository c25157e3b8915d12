// SPDX-License-Identifier: Apache-2.0
// The `.zbvh` codec and the assembly of a page; the check of a page is in page_check.cpp.
#include "streamer/world_format/bvh_page.h"

#include <algorithm>
#include <cstring>
#include <limits>

#include "base/check.h"

namespace zc {
namespace {

Error fault(const std::string& cause, const std::string& path, std::size_t at) {
  return {ErrorCode::kFormat, cause, path, static_cast<std::int64_t>(at)};
}

std::uint32_t low_high(std::uint32_t low, std::uint32_t high) { return low | high << 16U; }

}  // namespace

std::vector<std::byte> encode_bvh_file(const BvhFile& bvh) {
  ZC_CHECK(bvh.nodes.size() <= gpu::kRefFirstMask && bvh.order.size() <= gpu::kRefFirstMask);
  BvhFileHeader header;
  header.node_count = static_cast<std::uint32_t>(bvh.nodes.size());
  header.triangle_count = static_cast<std::uint32_t>(bvh.order.size());
  header.depth = bvh.depth;
  const std::size_t node_bytes = bvh.nodes.size() * sizeof(gpu::BvhNode);
  const std::size_t order_bytes = bvh.order.size() * sizeof(std::uint32_t);
  std::vector<std::byte> out(sizeof header + node_bytes + order_bytes);
  std::memcpy(out.data(), &header, sizeof header);
  if (node_bytes > 0) std::memcpy(out.data() + sizeof header, bvh.nodes.data(), node_bytes);
  if (order_bytes > 0) std::memcpy(out.data() + sizeof header + node_bytes, bvh.order.data(), order_bytes);
  return out;
}

Result<BvhFile> decode_bvh_file(std::span<const std::byte> bytes, const std::string& path) {
  BvhFileHeader header;
  if (bytes.size() < sizeof header) return fault("too short for a BVH file", path, bytes.size());
  std::memcpy(&header, bytes.data(), sizeof header);
  if (header.magic != BvhFileHeader{}.magic) return fault("not a zonecast BVH file", path, 0);
  if (header.node_count == 0 || header.node_count > gpu::kRefFirstMask)
    return fault("node count out of range", path, offsetof(BvhFileHeader, node_count));
  if (header.triangle_count == 0 || header.triangle_count > gpu::kRefFirstMask)
    return fault("triangle count out of range", path, offsetof(BvhFileHeader, triangle_count));
  if (header.depth == 0 || header.depth > gpu::kPageMaxDepth)
    return fault("depth out of range", path, offsetof(BvhFileHeader, depth));
  const std::size_t node_bytes = std::size_t{header.node_count} * sizeof(gpu::BvhNode);
  const std::size_t order_bytes = std::size_t{header.triangle_count} * sizeof(std::uint32_t);
  if (bytes.size() != sizeof header + node_bytes + order_bytes)
    return fault("size does not follow from its counts", path, bytes.size());

  BvhFile bvh;
  bvh.depth = header.depth;
  bvh.nodes.resize(header.node_count);
  std::memcpy(bvh.nodes.data(), bytes.data() + sizeof header, node_bytes);
  bvh.order.resize(header.triangle_count);
  std::memcpy(bvh.order.data(), bytes.data() + sizeof header + node_bytes, order_bytes);

  std::vector<bool> seen(header.triangle_count);
  for (std::size_t i = 0; i < bvh.order.size(); ++i) {
    const std::uint32_t triangle = bvh.order[i];
    if (triangle >= header.triangle_count || seen[triangle])
      return fault("the triangle order is not a permutation", path, sizeof header + node_bytes + 4 * i);
    seen[triangle] = true;
  }
  return bvh;
}

Result<std::vector<std::uint32_t>> assemble_page(const ZoneMesh& mesh, const BvhFile& bvh, const NodeRecord& node,
                                                 std::uint32_t material_count, const std::string& path) {
  if (bvh.nodes.size() != node.bvh_node_count || bvh.depth != node.bvh_depth)
    return Error{ErrorCode::kFormat, "the BVH is not the one that the index describes", path};
  if (mesh.triangles.size() != node.triangle_count || bvh.order.size() != node.triangle_count ||
      mesh.materials.size() != node.triangle_count)
    return Error{ErrorCode::kFormat, "mesh, BVH and index disagree on the number of triangles", path};

  const std::size_t node_words = bvh.nodes.size() * gpu::kBvhNodeWords;
  const std::size_t total_words = gpu::kPageHeaderWords + node_words + mesh.triangles.size() * gpu::kPageTriangleWords;
  if (node.page_bytes != 4 * total_words)
    return Error{ErrorCode::kFormat, "the page is not as large as the index says", path};

  std::vector<std::uint32_t> page(total_words);
  const gpu::PageHeader header = {
      .magic = gpu::kPageMagic,
      .node_count = static_cast<std::uint32_t>(bvh.nodes.size()),
      .triangle_count = static_cast<std::uint32_t>(mesh.triangles.size()),
      .node_offset_words = gpu::kPageHeaderWords,
      .triangle_offset_words = static_cast<std::uint32_t>(gpu::kPageHeaderWords + node_words),
      .depth = bvh.depth,
      .total_words = static_cast<std::uint32_t>(total_words),
      .reserved = 0,
  };
  std::memcpy(page.data(), &header, sizeof header);
  std::memcpy(page.data() + header.node_offset_words, bvh.nodes.data(), node_words * 4);

  std::uint32_t* out = page.data() + header.triangle_offset_words;
  for (const std::uint32_t source : bvh.order) {
    if (source >= mesh.triangles.size()) return Error{ErrorCode::kFormat, "the triangle order leaves the mesh", path};
    const std::array<std::uint32_t, 3>& corners = mesh.triangles[source];
    for (const std::uint32_t corner : corners)
      if (corner >= mesh.vertices.size()) return Error{ErrorCode::kFormat, "a triangle leaves the mesh", path};
    const auto& a = mesh.vertices[corners[0]];
    const auto& b = mesh.vertices[corners[1]];
    const auto& c = mesh.vertices[corners[2]];
    *out++ = low_high(a[0], a[1]);
    *out++ = low_high(a[2], b[0]);
    *out++ = low_high(b[1], b[2]);
    *out++ = low_high(c[0], c[1]);
    *out++ = low_high(c[2], mesh.materials[source]);
  }
  ZC_TRY(verify_page(page, material_count, path));
  return page;
}

}  // namespace zc
