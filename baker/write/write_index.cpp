// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/write/write_index.h"

#include "baker/write/tileset.h"

namespace zc {
namespace {

std::vector<MaterialRecord> material_records(std::span<const Material> materials) {
  std::vector<MaterialRecord> out;
  for (const Material& m : materials) {
    MaterialRecord record;
    record.base_color = {m.base_color.r, m.base_color.g, m.base_color.b};
    record.roughness = m.roughness;
    record.metallic = m.metallic;
    out.push_back(record);
  }
  return out;
}

}  // namespace

Result<WorldIndex> write_index(IndexInput&& input, BakeContext& context) {
  context.begin(BakeStage::kIndex);
  WorldIndex index;
  index.nodes = std::move(input.nodes);
  index.crs = std::move(input.crs);
  index.materials = material_records(input.materials);
  LatticeBox bounds;
  for (const NodeRecord& node : index.nodes) {
    bounds.add(node.bounds_min);
    bounds.add(node.bounds_max);
  }
  index.header.step_log2 = input.lattice.step_log2;
  index.header.anchor = input.lattice.anchor;
  index.header.source_triangles = input.source_triangles;
  index.header.bounds_min = bounds.min;
  index.header.bounds_max = bounds.max;
  index.header.node_count = static_cast<std::uint32_t>(index.nodes.size());
  index.header.material_count = static_cast<std::uint32_t>(index.materials.size());
  index.header.crs_bytes = static_cast<std::uint32_t>(index.crs.size());
  if (input.sun) index.header.sun = input.sun->pack();
  ZC_TRY(input.writer.write(kWorldIndexName, encode_world_index(index)));
  ZC_TRY(input.writer.write_text("tileset.json", make_tileset_json(index)));
  return index;
}

}  // namespace zc
