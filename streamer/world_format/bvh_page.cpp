// SPDX-License-Identifier: Apache-2.0
// The `.zbvh` codec. Assembling a page is in page_assembly.cpp, checking one in page_check.cpp.
#include "streamer/world_format/bvh_page.h"

#include <algorithm>
#include <cstring>

#include "base/check.h"
#include "streamer/world_format/page_view.h"

namespace zc {
namespace {

template <class T>
std::byte* put(std::byte* out, const std::vector<T>& values) {
  const std::size_t bytes = values.size() * sizeof(T);
  if (bytes > 0) std::memcpy(out, values.data(), bytes);
  return out + bytes;
}

template <class T>
const std::byte* take(const std::byte* in, std::size_t count, std::vector<T>& values) {
  values.resize(count);
  std::memcpy(values.data(), in, count * sizeof(T));
  return in + count * sizeof(T);
}

BvhFileHeader header_of(const BvhFile& bvh) {
  const ZoneAppearance& look = bvh.appearance;
  BvhFileHeader header;
  header.flags = (bvh.split ? gpu::kPageSplitTriangles : 0) | look.page_flags();
  header.node_count = static_cast<std::uint32_t>(bvh.nodes.size());
  header.reference_count = static_cast<std::uint32_t>(bvh.order.size());
  header.cluster_count = static_cast<std::uint32_t>(bvh.clusters.size());
  header.depth = bvh.depth;
  header.triangle_count = static_cast<std::uint32_t>(std::max(look.look_of.size(), look.light.size()));
  header.look_count = static_cast<std::uint32_t>(look.looks.size());
  header.curved_count = static_cast<std::uint32_t>(look.curved.size());
  header.atlas_size = look.atlas_size;
  header.texels_per_step = look.texels_per_step;
  return header;
}

// Of a header whose counts are in range.
std::uint64_t file_bytes(const BvhFileHeader& h) {
  std::uint64_t bytes = sizeof(BvhFileHeader) + sizeof(gpu::PageNode) * std::uint64_t{h.node_count} +
                        sizeof(std::uint32_t) * (std::uint64_t{h.reference_count} + h.cluster_count);
  if ((h.flags & gpu::kPageLooks) != 0)
    bytes += sizeof(gpu::Look) * std::uint64_t{h.look_count} + (std::uint64_t{h.triangle_count} + 1) / 2 * 4;
  if ((h.flags & gpu::kPageLight) != 0) bytes += sizeof(gpu::TriangleLight) * std::uint64_t{h.triangle_count};
  bytes += (sizeof(std::uint32_t) + sizeof(gpu::TriangleNormals)) * std::uint64_t{h.curved_count};
  if (h.atlas_size != 0) bytes += sizeof(std::uint32_t) * std::uint64_t{AtlasShape::unpack(h.atlas_size).words()};
  return bytes;
}

}  // namespace

std::vector<std::byte> encode_bvh_file(const BvhFile& bvh) {
  ZC_CHECK(bvh.nodes.size() <= gpu::kPageMaxNodes && bvh.order.size() <= gpu::kPageMaxTriangles);
  const ZoneAppearance& look = bvh.appearance;
  const BvhFileHeader header = header_of(bvh);
  std::vector<std::byte> out(file_bytes(header));
  std::memcpy(out.data(), &header, sizeof header);
  std::byte* at = put(put(put(out.data() + sizeof header, bvh.nodes), bvh.order), bvh.clusters);
  at = put(put(at, look.looks), look.look_of);
  at += look.look_of.size() % 2 * sizeof(std::uint16_t);
  at = put(put(put(put(at, look.light), look.curved), look.normals), look.atlas);
  ZC_CHECK(at == out.data() + out.size());
  return out;
}

Result<BvhFile> decode_bvh_file(std::span<const std::byte> bytes, const std::string& path) {
  const auto fault = [&](const char* cause, std::size_t at) {
    return Error{ErrorCode::kFormat, cause, path, static_cast<std::int64_t>(at)};
  };
  BvhFileHeader header;
  if (bytes.size() < sizeof header) return fault("too short for a BVH file", bytes.size());
  std::memcpy(&header, bytes.data(), sizeof header);
  if (header.magic != BvhFileHeader{}.magic) return fault("not a zonecast BVH file of this version", 0);
  if ((header.flags & ~gpu::kPageFlags) != 0) return fault("unknown flags", offsetof(BvhFileHeader, flags));
  if (header.node_count == 0 || header.node_count > gpu::kPageMaxNodes)
    return fault("node count out of range", offsetof(BvhFileHeader, node_count));
  if (header.reference_count == 0 || header.reference_count > gpu::kPageMaxTriangles)
    return fault("reference count out of range", offsetof(BvhFileHeader, reference_count));
  if (header.cluster_count == 0 || header.cluster_count > header.reference_count)
    return fault("cluster count out of range", offsetof(BvhFileHeader, cluster_count));
  if (header.depth == 0 || header.depth > gpu::kPageMaxDepth)
    return fault("depth out of range", offsetof(BvhFileHeader, depth));
  const bool looks = (header.flags & gpu::kPageLooks) != 0;
  const bool light = (header.flags & gpu::kPageLight) != 0;
  if (looks || light ? header.triangle_count == 0 || header.triangle_count > header.reference_count
                     : header.triangle_count != 0)
    return fault("triangle count out of range", offsetof(BvhFileHeader, triangle_count));
  if (looks ? header.look_count == 0 || header.look_count > kZoneLooksMax : header.look_count != 0)
    return fault("look count out of range", offsetof(BvhFileHeader, look_count));
  if ((header.flags & gpu::kPageNormals) != 0 ? header.curved_count == 0 || header.curved_count > header.reference_count
                                              : header.curved_count != 0)
    return fault("number of curved triangles out of range", offsetof(BvhFileHeader, curved_count));
  const AtlasShape atlas = AtlasShape::unpack(header.atlas_size);
  if (header.atlas_size != 0 && (!looks || !atlas.valid()))
    return fault("atlas size out of range", offsetof(BvhFileHeader, atlas_size));
  if (bytes.size() != file_bytes(header)) return fault("size does not follow from its counts", bytes.size());

  BvhFile bvh;
  bvh.split = (header.flags & gpu::kPageSplitTriangles) != 0;
  bvh.depth = header.depth;
  const std::byte* at = take(bytes.data() + sizeof header, header.node_count, bvh.nodes);
  at = take(at, header.reference_count, bvh.order);
  at = take(at, header.cluster_count, bvh.clusters);
  for (std::size_t i = 0; i < bvh.clusters.size(); ++i) {
    const bool in_place = i == 0 ? bvh.clusters[i] == 0 : bvh.clusters[i] > bvh.clusters[i - 1];
    if (!in_place || bvh.clusters[i] >= header.reference_count)
      return fault("the clusters are not in order",
                   static_cast<std::size_t>(at - bytes.data()) - 4 * (bvh.clusters.size() - i));
  }
  ZoneAppearance& look = bvh.appearance;
  if (looks) {
    at = take(at, header.look_count, look.looks);
    at = take(at, header.triangle_count, look.look_of);
    at += look.look_of.size() % 2 * sizeof(std::uint16_t);
  }
  if (light) at = take(at, header.triangle_count, look.light);
  at = take(at, header.curved_count, look.curved);
  at = take(at, header.curved_count, look.normals);
  if (header.atlas_size != 0) {
    look.atlas_size = header.atlas_size;
    look.texels_per_step = header.texels_per_step;
    take(at, atlas.words(), look.atlas);
  }
  return bvh;
}

}  // namespace zc
