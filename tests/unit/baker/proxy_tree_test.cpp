// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/proxy/proxy_tree.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/unit/baker/stages.h"
#include "tests/unit/baker/test_city.h"

namespace zc {
namespace {

constexpr std::uint32_t kLeafTriangles = 300;

struct Built {
  std::size_t cut_leaves = 0;
  double area = 0;  // of the cut zones
  ProxyTree proxies;
};

// Flat ground, of which every zone's proxy needs few triangles.
Built build_flat_ground(bool textured) {
  test::SceneMaker maker;
  for (int i = 0; i < 64 * 64; ++i) {
    const glm::dvec3 low((i % 64) * 7.3, (i / 64) * 7.3, 1);
    const glm::dvec3 x(7.3, 0, 0), y(0, 7.3, 0);
    maker.triangle(low, low + x, low + x + y, 0);
    maker.triangle(low, low + x + y, low + y, 0);
  }
  maker.object(ObjectKind::kGround);
  CutScene scene = test::cut(test::snapped(std::move(maker.scene)), kLeafTriangles);
  if (textured)
    for (Material& material : scene.materials) material.texture = SurfaceTexture{};
  Built out;
  for (const Zone& zone : scene.tree.zones) {
    out.cut_leaves += zone.children.empty() ? 1 : 0;
    out.area += area_of(zone.detail);
  }
  BakeCache cache;
  BakeContext context;
  out.proxies = *build_proxies(
      {std::move(scene.tree), scene.lattice.step_m(), 0.1, kLeafTriangles, textured, cache, scene.materials}, context);
  return out;
}

TEST(ProxyTree, NeighboursWithSmallProxiesAreOneZone) {
  const Built built = build_flat_ground(false);
  double area = 0;
  std::size_t leaves = 0;
  for (const ProxyNode& node : built.proxies.nodes) {
    if (!node.is_detail) continue;
    ++leaves;
    area += area_of(node.proxy.mesh);
    const ProxyNode& leaf = built.proxies.nodes[static_cast<std::size_t>(node.parent)];
    EXPECT_LE(leaf.proxy.mesh.faces.size(), kLeafTriangles);
    EXPECT_LE(leaf.proxy.error.max_m, 0.1);
    EXPECT_LE(node.proxy.mesh.faces.size(), kDetailZonesLimit * kLeafTriangles);
    EXPECT_NEAR(area_of(leaf.proxy.mesh) / area_of(node.proxy.mesh), 1, 1e-3);
  }
  EXPECT_GE(built.cut_leaves, 32U);
  EXPECT_LE(leaves, built.cut_leaves / 2);
  EXPECT_NEAR(area / built.area, 1, 1e-9);
}

TEST(ProxyTree, NoTwoTexturedZonesShareAnAtlas) {
  const Built built = build_flat_ground(true);
  EXPECT_EQ(std::ranges::count_if(built.proxies.nodes, &ProxyNode::is_detail), built.cut_leaves);
}

}  // namespace
}  // namespace zc
