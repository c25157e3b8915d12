// SPDX-License-Identifier: GPL-3.0-or-later
// From a zone's mesh to its `.zbvh` and its GPU page.
// Deterministic. Thread-safe: no state. Fails as build_wide_bvh and assemble_page do.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "baker/bvh/build_wide.h"
#include "streamer/world_format/bvh_page.h"

namespace zc {

struct BuiltPage {
  BvhFile bvh;
  std::vector<std::uint32_t> words;
};

std::vector<BvhTriangle> bvh_triangles(const ZoneMesh& mesh);

// `node` has the mesh's origin, step, counts and error; its BVH's counts and its page's bytes are filled in.
// `appearance` is of the mesh. name: of the file that errors speak of.
Result<BuiltPage> build_page(const ZoneMesh& mesh, ZoneAppearance appearance, const BvhBuildOptions& options,
                             std::uint32_t material_count, NodeRecord& node, const std::string& name);

// The same from a tree over bvh_triangles(mesh).
Result<BuiltPage> lay_out_page(const WideTree& tree, const ZoneMesh& mesh, ZoneAppearance appearance,
                               std::uint32_t material_count, NodeRecord& node, const std::string& name);

}  // namespace zc
