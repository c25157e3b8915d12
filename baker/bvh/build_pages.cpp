// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/bvh/build_pages.h"

#include <xxhash.h>

#include <algorithm>
#include <string>
#include <utility>

#include "baker/bvh/build_page.h"

namespace zc {
namespace {

Status write_page(const ZoneMesh& mesh, ZoneAppearance appearance, const PagesInput& input, NodeRecord& node,
                  DiskParts& disk) {
  const std::string name = node_file(node, "zbvh");
  ZC_ASSIGN(const BuiltPage page,
            build_page(mesh, std::move(appearance), input.options, input.material_count, node, name));
  const auto [bytes, parts] = encode_bvh_file(page.bvh, mesh, node);
  disk.bvh = parts;
  node.bvh_bytes = bytes.size();
  node.scratch_bytes = std::max(node.scratch_bytes, page_scratch_bytes(node, mesh.vertices.size()));
  node.bvh_xxh3 = XXH3_64bits(bytes.data(), bytes.size());
  ZoneMesh read = {mesh.vertices, mesh.triangles, {}};
  ZC_ASSIGN(const BvhFile decoded, decode_bvh_file(bytes, read, node, name));
  ZC_ASSIGN(const std::vector<std::uint32_t> words, assemble_page(read, decoded, node, input.material_count, name));
  if (words != page.words) return Error{ErrorCode::kFormat, "is not the page that it was made from", name};
  return input.writer.write(name, bytes);
}

}  // namespace

Result<Pages> build_pages(PagesInput&& input, BakeContext& context) {
  context.begin(BakeStage::kBvh, input.records.size());
  Pages out = {std::move(input.records), std::move(input.disk)};
  ZC_TRY(context.for_each(out.records.size(), [&](std::size_t i) {
    const ZoneMesh mesh = std::move(input.meshes[i]);  // and its memory is free when its page is written
    return write_page(mesh, std::move(input.appearances[i]), input, out.records[i], out.disk[i]);
  }));
  return out;
}

}  // namespace zc
