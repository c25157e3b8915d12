// SPDX-License-Identifier: Apache-2.0
// The `.zbvh` codec. Assembling a page is in page_assembly.cpp, checking one in page_check.cpp.
#include "streamer/world_format/bvh_page.h"

#include <cstring>

#include "base/check.h"

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

}  // namespace

std::vector<std::byte> encode_bvh_file(const BvhFile& bvh) {
  ZC_CHECK(bvh.nodes.size() <= gpu::kPageMaxNodes && bvh.order.size() <= gpu::kPageMaxTriangles);
  BvhFileHeader header;
  header.flags = bvh.flags;
  header.node_count = static_cast<std::uint32_t>(bvh.nodes.size());
  header.reference_count = static_cast<std::uint32_t>(bvh.order.size());
  header.cluster_count = static_cast<std::uint32_t>(bvh.clusters.size());
  header.depth = bvh.depth;
  std::vector<std::byte> out(bvh_file_bytes(header.node_count, header.reference_count, header.cluster_count));
  std::memcpy(out.data(), &header, sizeof header);
  put(put(put(out.data() + sizeof header, bvh.nodes), bvh.order), bvh.clusters);
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
  if ((header.flags & ~gpu::kPageSplitTriangles) != 0) return fault("unknown flags", offsetof(BvhFileHeader, flags));
  if (header.node_count == 0 || header.node_count > gpu::kPageMaxNodes)
    return fault("node count out of range", offsetof(BvhFileHeader, node_count));
  if (header.reference_count == 0 || header.reference_count > gpu::kPageMaxTriangles)
    return fault("reference count out of range", offsetof(BvhFileHeader, reference_count));
  if (header.cluster_count == 0 || header.cluster_count > header.reference_count)
    return fault("cluster count out of range", offsetof(BvhFileHeader, cluster_count));
  if (header.depth == 0 || header.depth > gpu::kPageMaxDepth)
    return fault("depth out of range", offsetof(BvhFileHeader, depth));
  if (bytes.size() != bvh_file_bytes(header.node_count, header.reference_count, header.cluster_count))
    return fault("size does not follow from its counts", bytes.size());

  BvhFile bvh;
  bvh.flags = header.flags;
  bvh.depth = header.depth;
  const std::byte* at = take(bytes.data() + sizeof header, header.node_count, bvh.nodes);
  at = take(at, header.reference_count, bvh.order);
  take(at, header.cluster_count, bvh.clusters);
  for (std::size_t i = 0; i < bvh.clusters.size(); ++i) {
    const bool in_place = i == 0 ? bvh.clusters[i] == 0 : bvh.clusters[i] > bvh.clusters[i - 1];
    if (!in_place || bvh.clusters[i] >= header.reference_count)
      return fault("the clusters are not in order", bytes.size() - 4 * (bvh.clusters.size() - i));
  }
  return bvh;
}

}  // namespace zc
