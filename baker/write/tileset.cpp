// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/write/tileset.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <vector>

#include "baker/scene/lattice_mesh.h"

namespace zc {
namespace {

using Json = nlohmann::ordered_json;

// Centre and half axes, metres relative to the anchor, z up.
Json box_json(const LatticeBox& box, double step_m) {
  std::array<double, 3> center = {};
  std::array<double, 3> half = {};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    center[axis] = (double(box.min[axis]) + double(box.max[axis])) / 2 * step_m;
    half[axis] = (double(box.max[axis]) - double(box.min[axis])) / 2 * step_m;
  }
  return {center[0], center[1], center[2], half[0], 0, 0, 0, half[1], 0, 0, 0, half[2]};
}

}  // namespace

std::string make_tileset_json(const WorldIndex& index) {
  const double step_m = index.step_m();
  // Parents come before children: one backward pass grows every volume over its descendants and builds its tile.
  std::vector<LatticeBox> boxes(index.nodes.size());
  std::vector<Json> tiles(index.nodes.size());
  for (std::size_t i = index.nodes.size(); i-- > 0;) {
    const NodeRecord& node = index.nodes[i];
    boxes[i].add(node.bounds_min);
    boxes[i].add(node.bounds_max);
    Json children = Json::array();
    for (std::uint32_t c = node.first_child; c < node.first_child + node.child_count; ++c) {
      boxes[i].add(boxes[c]);
      children.push_back(std::move(tiles[c]));
    }
    Json& tile = tiles[i];
    tile["boundingVolume"]["box"] = box_json(boxes[i], step_m);
    tile["geometricError"] = node.is_detail() ? 0.0 : static_cast<double>(node.visible_error_m());
    if (i == 0) {
      tile["refine"] = "REPLACE";
      const auto metres = [&](std::size_t axis) { return static_cast<double>(index.header.anchor[axis]) * step_m; };
      tile["transform"] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, metres(0), metres(1), metres(2), 1};
    }
    tile["content"]["uri"] = node_file(node, "glb");
    if (!children.empty()) tile["children"] = std::move(children);
  }
  Json out;
  out["asset"] = {{"version", "1.1"}, {"generator", "zonecast"}};
  // The error of drawing nothing: the world's own size bounds it.
  out["geometricError"] =
      std::max(boxes[0].diagonal() * step_m, 2.0 * static_cast<double>(index.nodes[0].visible_error_m()));
  out["extras"] = {{"zonecast_index", kWorldIndexName}};
  if (!index.crs.empty()) out["extras"]["crs"] = index.crs;
  out["root"] = std::move(tiles[0]);
  return out.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace zc
