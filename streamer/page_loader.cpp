// SPDX-License-Identifier: Apache-2.0
#include "streamer/page_loader.h"

#include <xxhash.h>

#include <exception>
#include <span>
#include <string>

#include "streamer/world_format/bvh_page.h"

namespace zc {
namespace {

Status verify(std::span<const std::byte> data, std::uint64_t bytes, std::uint64_t xxh3, const std::string& name) {
  if (data.size() != bytes) return Error{ErrorCode::kIo, "the source returned another size than asked for", name};
  if (XXH3_64bits(data.data(), data.size()) != xxh3)
    return Error{ErrorCode::kFormat, "hash differs from the index: the file is damaged", name};
  return {};
}

struct ZoneFiles {
  std::vector<std::byte> glb, bvh;
};

Result<ZoneFiles> read_files(Source& source, const NodeRecord& record, const std::string& glb_name,
                             const std::string& bvh_name) {
  ZoneFiles files;
  ZC_ASSIGN(files.glb, source.read(glb_name, record.glb_bytes));
  ZC_ASSIGN(files.bvh, source.read(bvh_name, record.bvh_bytes));
  return files;
}

Result<std::vector<std::uint32_t>> load(Source& source, const WorldIndex& index, std::uint32_t node,
                                        std::chrono::steady_clock::time_point* read_at) {
  const NodeRecord& record = index.nodes[node];
  const std::string glb_name = node_file(record, "glb");
  const std::string bvh_name = node_file(record, "zbvh");
  Result<ZoneFiles> files = read_files(source, record, glb_name, bvh_name);
  if (read_at != nullptr) *read_at = std::chrono::steady_clock::now();
  if (!files) return std::move(files).error();
  ZC_TRY(verify(files->glb, record.glb_bytes, record.glb_xxh3, glb_name));
  ZC_ASSIGN(ZoneMesh mesh, decode_zone_glb(files->glb, record, glb_name));
  files->glb = std::vector<std::byte>();  // `= {}` would keep its memory
  ZC_TRY(verify(files->bvh, record.bvh_bytes, record.bvh_xxh3, bvh_name));
  ZC_ASSIGN(const BvhFile bvh, decode_bvh_file(files->bvh, mesh, record, bvh_name));
  files->bvh = std::vector<std::byte>();
  return assemble_page(mesh, bvh, record, static_cast<std::uint32_t>(index.materials.size()), bvh_name);
}

}  // namespace

Result<std::vector<std::uint32_t>> load_page(Source& source, const WorldIndex& index, std::uint32_t node,
                                             std::chrono::steady_clock::time_point* read_at) {
  try {
    return load(source, index, node, read_at);
  } catch (const std::exception& exception) {  // bad_alloc: the machine has less than the cap
    return Error{ErrorCode::kIo, std::string("cannot load: ") + exception.what(), node_file(index.nodes[node], "glb")};
  }
}

std::uint64_t compressed_bytes(const NodeRecord& node) { return node.glb_bytes + node.bvh_bytes; }

std::uint64_t scratch_bytes(const NodeRecord& node) {
  if (node.scratch_bytes != 0) return node.scratch_bytes;  // decoding refuses to take more
  return decode_scratch_bound(node, node.glb_bytes);
}

}  // namespace zc
