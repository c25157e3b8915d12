// SPDX-License-Identifier: Apache-2.0
#include "streamer/page_loader.h"

#include <xxhash.h>

#include <exception>
#include <span>
#include <string>

#include "streamer/world_format/bvh_page.h"

namespace zc {
namespace {

Result<std::vector<std::byte>> read_verified(Source& source, const std::string& name, std::uint64_t bytes,
                                             std::uint64_t xxh3) {
  ZC_ASSIGN(std::vector<std::byte> data, source.read(name, bytes));
  if (data.size() != bytes) return Error{ErrorCode::kIo, "the source returned another size than asked for", name};
  if (XXH3_64bits(data.data(), data.size()) != xxh3)
    return Error{ErrorCode::kFormat, "hash differs from the index: the file is damaged", name};
  return data;
}

Result<std::vector<std::uint32_t>> load(Source& source, const WorldIndex& index, std::uint32_t node) {
  const NodeRecord& record = index.nodes[node];
  const std::string glb_name = node_file(record, "glb");
  const std::string bvh_name = node_file(record, "zbvh");
  ZoneMesh mesh;
  {
    ZC_ASSIGN(const std::vector<std::byte> glb, read_verified(source, glb_name, record.glb_bytes, record.glb_xxh3));
    ZC_ASSIGN(mesh, decode_zone_glb(glb, record, glb_name));
  }
  BvhFile bvh;
  {
    ZC_ASSIGN(const std::vector<std::byte> file, read_verified(source, bvh_name, record.bvh_bytes, record.bvh_xxh3));
    ZC_ASSIGN(bvh, decode_bvh_file(file, mesh, record, bvh_name));
  }
  return assemble_page(mesh, bvh, record, static_cast<std::uint32_t>(index.materials.size()), bvh_name);
}

}  // namespace

Result<std::vector<std::uint32_t>> load_page(Source& source, const WorldIndex& index, std::uint32_t node) {
  try {
    return load(source, index, node);
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
