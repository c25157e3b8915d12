// SPDX-License-Identifier: Apache-2.0
#include "streamer/paging/page_loader.h"

#include <exception>
#include <span>
#include <string>

#include "streamer/source/retry.h"
#include "streamer/world_format/bvh_page.h"

namespace zc {
namespace {

Result<std::vector<std::uint32_t>> load(AsyncRead& files, const NodeRecord& node, std::size_t materials,
                                        std::chrono::steady_clock::time_point* read_at) {
  const std::string bvh_name = node_file(node, "zbvh");
  Result<std::span<const std::byte>> glb = files.wait(0);
  Result<std::span<const std::byte>> tree = glb.ok() ? files.wait(1) : Error{};
  if (read_at != nullptr) *read_at = std::chrono::steady_clock::now();
  if (!glb) return std::move(glb).error();
  if (!tree) return std::move(tree).error();
  ZC_ASSIGN(ZoneMesh mesh, decode_zone_glb(*glb, node, node_file(node, "glb")));
  ZC_ASSIGN(const BvhFile bvh, decode_bvh_file(*tree, mesh, node, bvh_name));
  return assemble_page(mesh, bvh, node, static_cast<std::uint32_t>(materials), bvh_name);
}

}  // namespace

std::vector<WantedFile> page_files(const NodeRecord& node) {
  return {{node_file(node, "glb"), node.glb_bytes, node.glb_xxh3},
          {node_file(node, "zbvh"), node.bvh_bytes, node.bvh_xxh3}};
}

Result<std::vector<std::uint32_t>> load_page(AsyncRead& files, const NodeRecord& node, std::size_t materials,
                                             std::chrono::steady_clock::time_point* read_at) {
  try {
    return load(files, node, materials, read_at);
  } catch (const std::exception& exception) {  // bad_alloc: the machine has less than the cap
    return Error{ErrorCode::kIo, std::string("cannot load: ") + exception.what(), node_file(node, "glb")};
  }
}

Result<std::vector<std::uint32_t>> load_page(Source& source, const IndexView& index, std::uint32_t node) {
  const NodeRecord record = index.nodes[node];
  return with_retries([&] { return load_page(*source.begin(page_files(record)), record, index.materials.size()); });
}

std::uint64_t compressed_bytes(const NodeRecord& node) { return node.glb_bytes + node.bvh_bytes; }

std::uint64_t scratch_bytes(const NodeRecord& node) {
  if (node.scratch_bytes != 0) return node.scratch_bytes;  // decoding refuses to take more
  return decode_scratch_bound(node, node.glb_bytes);
}

}  // namespace zc
