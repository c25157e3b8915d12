// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/encode/encode_nodes.h"

#include <xxhash.h>

#include <cmath>
#include <limits>
#include <set>
#include <string>

#include "baker/encode/zone_glb.h"

namespace zc {
namespace {

// What is known before the mesh is encoded.
NodeRecord begin_record(const ProxyNode& source) {
  NodeRecord node;
  node.parent = source.parent;
  node.first_child = source.child_count > 0 ? source.first_child : 0;
  node.child_count = source.child_count;
  node.flags = source.is_detail ? kNodeDetail : 0;
  node.depth = source.depth;
  node.cell_x = source.cell_x;
  node.cell_y = source.cell_y;
  node.step_shift = source.proxy.step_shift;
  const SurfaceError& error = source.proxy.error;
  node.error_max_m = static_cast<float>(error.max_m);
  // Still a bound when rounded.
  if (static_cast<double>(node.error_max_m) < error.max_m)
    node.error_max_m = std::nextafter(node.error_max_m, std::numeric_limits<float>::infinity());
  node.appearance_error_m = static_cast<float>(error.appearance_m);
  node.error_mean_m = static_cast<float>(error.mean_m);
  node.normal_deviation_deg = static_cast<float>(error.normal_deviation_deg);
  node.color_error = static_cast<float>(error.color_error);
  return node;
}

Status encode_node(const ProxyNode& source, const EncodeInput& input, NodeRecord& node, ZoneMesh& decoded,
                   DiskParts& disk) {
  node = begin_record(source);
  ZC_ASSIGN(const EncodedZone zone, encode_zone_glb(source.proxy.mesh, node.step_shift, input.materials, input.step_m));
  node.origin = zone.origin;
  node.bounds_min = zone.bounds_min;
  node.bounds_max = zone.bounds_max;
  node.triangle_count = zone.triangle_count;
  node.vertex_count = zone.vertex_count;
  node.primitive_count = zone.primitive_count;
  node.scratch_bytes = decode_scratch_bytes(zone.glb, node);  // build_pages knows the rest
  node.glb_bytes = zone.glb.size();
  disk.triangles = zone.triangle_count;
  disk.mesh = zone.draco_bytes;
  disk.json = zone.glb.size() - zone.draco_bytes;
  node.glb_xxh3 = XXH3_64bits(zone.glb.data(), zone.glb.size());
  const std::string name = node_file(node, "glb");
  ZC_ASSIGN(decoded, decode_zone_glb(zone.glb, node, name));
  decoded.materials = zone.materials;
  return input.writer.write(name, zone.glb);
}

}  // namespace

Result<EncodedNodes> encode_nodes(EncodeInput&& input, BakeContext& context) {
  const std::size_t count = input.nodes.size();
  context.begin(BakeStage::kEncode, count);
  std::set<std::uint32_t> depths;
  for (const ProxyNode& node : input.nodes) depths.insert(node.depth);
  for (const std::uint32_t depth : depths) ZC_TRY(input.writer.make_directory("zones/" + std::to_string(depth)));
  EncodedNodes out;
  out.records.resize(count);
  out.meshes.resize(count);
  out.disk.resize(count);
  ZC_TRY(context.for_each(count, [&](std::size_t i) {
    return encode_node(input.nodes[i], input, out.records[i], out.meshes[i], out.disk[i]);
  }));
  return out;
}

}  // namespace zc
