// SPDX-License-Identifier: GPL-3.0-or-later
// Meshes with the faults that cities ship with, baked; what is stored is held against the source by distances of its
// own: another tree, another point-to-triangle formula, plain doubles.
#include <gtest/gtest.h>
#include <stdlib.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <limits>
#include <random>

#include "baker/bake.h"
#include "baker/encode/zone_glb.h"
#include "base/file.h"
#include "streamer/world_format/bvh_page.h"
#include "streamer/world_format/page_view.h"
#include "tests/numerics/triangle_tree.h"
#include "tests/unit/baker/test_city.h"

namespace zc {
namespace {

namespace fs = std::filesystem;
using test::area_of;
using test::farthest;
using test::kSamples;
using test::sample;
using test::SceneMaker;
using test::Triangle;
using test::TriangleTree;

constexpr double kStepM = 1.0 / 256;

struct StoredNode {
  NodeRecord record;
  std::vector<Triangle> triangles;  // metres from the anchor
  std::vector<gpu::TriangleLight> light;
};

// What the streamer would page in, by the formats' own readers.
void read_nodes(const fs::path& world, std::vector<StoredNode>& out, WorldIndex& index) {
  const auto bytes = read_file(world / kWorldIndexName, 1U << 30U);
  ASSERT_TRUE(bytes.ok());
  auto decoded = decode_world_index(*bytes, "world.zcw");
  ASSERT_TRUE(decoded.ok()) << decoded.error().describe();
  index = *std::move(decoded);
  for (const NodeRecord& node : index.nodes) {
    const std::string name = node_file(node, "glb");
    const auto glb = read_file(world / name, 1U << 30U);
    const auto zbvh = read_file(world / node_file(node, "zbvh"), 1U << 30U);
    ASSERT_TRUE(glb.ok() && zbvh.ok()) << name;
    auto mesh = decode_zone_glb(*glb, node, name);
    ASSERT_TRUE(mesh.ok()) << mesh.error().describe();
    const auto bvh = decode_bvh_file(*zbvh, *mesh, node, name);
    ASSERT_TRUE(bvh.ok()) << bvh.error().describe();
    const auto page = assemble_page(*mesh, *bvh, node, index.header.material_count, name);
    ASSERT_TRUE(page.ok()) << page.error().describe();
    const PageView view(*page);
    StoredNode stored{node, {}, bvh->appearance.light};
    ASSERT_GE(view.header().triangle_count, node.triangle_count);  // more where the tree refers to one twice
    for (std::uint32_t t = 0; t < view.header().triangle_count; ++t) {
      const auto corners = view.triangle(t).corners;
      Triangle& triangle = stored.triangles.emplace_back();
      for (std::size_t k = 0; k < 3; ++k)
        for (std::size_t axis = 0; axis < 3; ++axis)
          triangle[k][static_cast<int>(axis)] = static_cast<double>(corners[k][axis]) * index.step_m();
    }
    out.push_back(std::move(stored));
  }
}

// Half a step's diagonal, of steps 2^shift as long.
double rounding_m(std::uint32_t shift) { return std::ldexp(kStepM * std::sqrt(0.75), static_cast<int>(shift)); }

std::uint64_t dropped_triangles(const BakeReport& report) {
  std::uint64_t count = 0;
  for (const auto* counts : {&report.repair.counts, &report.notes})
    for (const ImportCount& c : *counts)
      if (c.what.starts_with("triangles") && c.what.find("turned") == std::string::npos) count += c.count;
  return count;
}

class AdversarialBake : public ::testing::Test {
 protected:
  void SetUp() override {
    std::string pattern = (fs::temp_directory_path() / "zonecast-adversarial-XXXXXX").string();
    ASSERT_NE(mkdtemp(pattern.data()), nullptr);
    folder_ = pattern;
  }
  void TearDown() override { fs::remove_all(folder_); }

  Result<BakeReport> bake(Scene scene, std::uint32_t leaf_triangles = 400, bool light = true) {
    BakeOptions options;
    options.threads = 2;
    options.leaf_triangles = leaf_triangles;
    options.reuse = false;
    options.light = light;
    return bake_world(std::move(scene), 0, options, folder_ / "world");
  }

  // Bakes, and holds every node against the detail below it, and the detail against the source.
  // border_m: how far cuts of ground may round its borders.
  void expect_bounds(const Scene& scene, std::uint32_t leaf_triangles = 400, double border_m = 0) {
    const auto report = bake(scene, leaf_triangles);
    ASSERT_TRUE(report.ok()) << report.error().describe();
    WorldIndex index;
    std::vector<StoredNode> nodes;
    ASSERT_NO_FATAL_FAILURE(read_nodes(folder_ / "world", nodes, index));

    // Children follow their parents.
    std::vector<std::vector<Triangle>> detail(nodes.size());
    std::vector<std::uint32_t> shift(nodes.size());
    for (std::size_t i = nodes.size(); i-- > 0;) {
      if (nodes[i].record.is_detail()) {
        detail[i] = nodes[i].triangles;
        shift[i] = nodes[i].record.step_shift;
      }
      if (i == 0) break;
      const auto parent = static_cast<std::size_t>(nodes[i].record.parent);
      ASSERT_LT(parent, i);
      detail[parent].insert(detail[parent].end(), detail[i].begin(), detail[i].end());
      shift[parent] = std::max(shift[parent], shift[i]);
      EXPECT_LE(nodes[i].record.error_max_m, nodes[parent].record.error_max_m);
    }
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      const StoredNode& node = nodes[i];
      EXPECT_GT(node.triangles.size(), 0U);
      if (node.record.is_detail()) continue;
      // Details are rounded to their own steps; the bounds are to what they were before.
      const double rounding = shift[i] > 0 ? rounding_m(shift[i]) : 0;
      const double allowed = node.record.error_max_m + rounding + 1e-9;
      const TriangleTree below(detail[i]);
      const TriangleTree proxy(node.triangles);
      EXPECT_LE(farthest(proxy.triangles(), below), allowed) << "node " << i << " of depth " << node.record.depth;
      EXPECT_LE(farthest(below.triangles(), proxy), allowed) << "node " << i << " of depth " << node.record.depth;
      // A bound that says little is no bound.
      const bool is_leaf = nodes[node.record.first_child].record.is_detail();
      if (is_leaf && node.record.parent >= 0 && shift[i] == 0) {
        EXPECT_LE(node.record.error_max_m, 0.10F);
      }
    }

    std::vector<Triangle> source;
    const glm::dvec3 anchor(index.header.anchor[0], index.header.anchor[1], index.header.anchor[2]);
    for (const auto& t : scene.triangles) {
      Triangle& triangle = source.emplace_back();
      for (std::size_t k = 0; k < 3; ++k) triangle[k] = scene.positions[t[k]] - anchor * index.step_m();
    }
    const double moved = rounding_m(0) + report->repair.border_error_m + rounding_m(shift[0]) + border_m + 1e-6;
    const TriangleTree whole(source);
    const TriangleTree stored(detail[0]);
    EXPECT_LE(farthest(stored.triangles(), whole), moved);
    std::mt19937_64 random(5);
    const double area_per_sample = area_of(source) / kSamples;
    std::uint64_t lost = 0;
    for (const Triangle& t : source) {
      double most = 0;
      sample(t, area_per_sample, random,
             [&](const glm::dvec3& p) { most = std::max(most, stored.distance(p, moved)); });
      lost += most > moved ? 1 : 0;
    }
    EXPECT_LE(lost, dropped_triangles(*report)) << "triangles of the source that are gone and that nobody counted";
  }

  fs::path folder_;
};

glm::dvec3 random_point(std::mt19937_64& random, double size) {
  std::uniform_real_distribution<double> unit(0, size);
  const double x = unit(random);
  const double y = unit(random);
  return {x, y, unit(random)};
}

glm::dvec3 random_direction(std::mt19937_64& random) {
  const glm::dvec3 d = random_point(random, 2) - 1.0;
  return glm::length(d) > 0.1 ? glm::normalize(d) : glm::dvec3(0, 0, 1);
}

void bar(SceneMaker& maker, const glm::dvec3& a, const glm::dvec3& b, double radius, int sides) {
  const glm::dvec3 along = glm::normalize(b - a);
  const glm::dvec3 u =
      glm::normalize(glm::cross(along, std::abs(along.z) < 0.9 ? glm::dvec3(0, 0, 1) : glm::dvec3(1, 0, 0)));
  const glm::dvec3 v = glm::cross(along, u);
  const auto at = [&](const glm::dvec3& end, int i) {
    const double angle = 2 * M_PI * i / sides;
    return end + (u * std::cos(angle) + v * std::sin(angle)) * radius;
  };
  for (int i = 0; i < sides; ++i) {
    maker.quad(at(a, i), at(a, i + 1), at(b, i + 1), at(b, i), 0);
    maker.triangle(a, at(a, i + 1), at(a, i), 0);
    maker.triangle(b, at(b, i), at(b, i + 1), 0);
  }
}

TEST_F(AdversarialBake, UnweldedSoup) {
  Scene scene = test::small_city();
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> off(-0.02, 0.02);
  for (glm::dvec3& p : scene.positions) p += glm::dvec3(off(random), off(random), off(random));
  expect_bounds(scene, 600, 0.1);
}

TEST_F(AdversarialBake, Holes) {
  const Scene city = test::small_city();
  SceneMaker maker;
  for (const SceneObject& object : city.objects) {
    for (std::uint32_t t = object.first_triangle; t < object.first_triangle + object.triangle_count; ++t) {
      if (t % 5 == 2) continue;
      const auto& v = city.triangles[t];
      maker.triangle(city.positions[v[0]], city.positions[v[1]], city.positions[v[2]], city.triangle_material[t]);
    }
    maker.object(object.kind);
  }
  expect_bounds(maker.scene, 600, 0.1);
}

TEST_F(AdversarialBake, CopiedAndFlippedFaces) {
  const Scene city = test::small_city();
  SceneMaker maker;
  for (const SceneObject& object : city.objects) {
    for (std::uint32_t t = object.first_triangle; t < object.first_triangle + object.triangle_count; ++t) {
      const auto& v = city.triangles[t];
      const std::array<glm::dvec3, 3> p = {city.positions[v[0]], city.positions[v[1]], city.positions[v[2]]};
      maker.triangle(p[0], p[1], p[2], city.triangle_material[t]);
      if (t % 2 == 0) maker.triangle(p[1], p[2], p[0], 1);
      if (t % 3 == 0) maker.triangle(p[0], p[2], p[1], 2);
    }
    maker.object(object.kind);
  }
  expect_bounds(maker.scene, 600, 0.1);
}

TEST_F(AdversarialBake, BoxesThroughEachOther) {
  std::mt19937_64 random(2);
  SceneMaker maker;
  for (int i = 0; i < 200; ++i) {
    const glm::dvec3 low = random_point(random, 20);
    SceneMaker box;
    box.box(glm::dvec3(0), random_point(random, 8) + 0.2);
    const glm::dvec3 x = random_direction(random);
    const glm::dvec3 y = glm::normalize(glm::cross(x, random_direction(random)));
    const glm::dmat3 turn(x, y, glm::cross(x, y));
    for (const auto& t : box.scene.triangles)
      maker.triangle(low + turn * box.scene.positions[t[0]], low + turn * box.scene.positions[t[1]],
                     low + turn * box.scene.positions[t[2]], static_cast<std::uint16_t>(i % 4));
    if (i % 10 == 9) maker.object(ObjectKind::kObject);
  }
  expect_bounds(maker.scene);
}

TEST_F(AdversarialBake, SliversAndNeedles) {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> width(0, 0.03);
  SceneMaker maker;
  for (int i = 0; i < 1500; ++i) {
    const glm::dvec3 a = random_point(random, 30);
    const glm::dvec3 b = a + random_direction(random) * (1.0 + i % 20);
    const glm::dvec3 side = random_direction(random) * width(random);
    maker.triangle(a, b, i % 2 == 0 ? a + side : (a + b) * 0.5 + side, 0);
    if (i % 100 == 99) maker.object(ObjectKind::kObject);
  }
  expect_bounds(maker.scene);
}

TEST_F(AdversarialBake, FacesWithoutArea) {
  Scene scene = test::small_city();
  SceneMaker maker;
  maker.scene = scene;
  maker.scene.objects.clear();
  for (int i = 0; i < 500; ++i) {
    const glm::dvec3 p(i % 30, i % 17, 3);
    const glm::dvec3 q = p + glm::dvec3(1, 2, 0.5);
    if (i % 3 == 0) maker.triangle(p, p, p, 0);
    if (i % 3 == 1) maker.triangle(p, q, p, 1);
    if (i % 3 == 2) maker.triangle(p, (p + q) * 0.5, q, 2);
  }
  maker.object(ObjectKind::kObject);
  expect_bounds(maker.scene, 600, 0.1);
}

TEST_F(AdversarialBake, SheetsBackToBack) {
  SceneMaker maker;
  for (int i = 0; i < 60; ++i) {
    const glm::dvec3 p((i % 8) * 4.0, (i / 8) * 4.0, 0);
    for (int k = 0; k < 12; ++k) {
      const glm::dvec3 a = p + glm::dvec3(k * 0.25, 0, 0);
      const glm::dvec3 x(0.25, 0.1 * (k % 3), 0);
      const glm::dvec3 z(0, 0, 3);
      maker.quad(a, a + x, a + x + z, a + z, 0);
      maker.quad(a, a + z, a + x + z, a + x, 1);
      if (i % 4 == 1 && k % 4 == 3) maker.object(ObjectKind::kObject);
    }
    maker.object(ObjectKind::kObject);
  }
  expect_bounds(maker.scene);
}

TEST_F(AdversarialBake, TJunctions) {
  SceneMaker maker;
  for (int i = 0; i < 20; ++i) {
    const double y = i * 9.0;
    maker.quad({0, y, 0}, {30, y, 0}, {30, y, 5}, {0, y, 5}, 0);
    for (int k = 0; k < 37; ++k)
      maker.quad({k * 30 / 37.0, y, 5}, {(k + 1) * 30 / 37.0, y, 5}, {(k + 1) * 30 / 37.0, y + 4, 7},
                 {k * 30 / 37.0, y + 4, 7}, 1);
    for (int k = 0; k < 11; ++k)
      maker.quad({k * 30 / 11.0, y + 4, 7}, {(k + 1) * 30 / 11.0, y + 4, 7}, {(k + 1) * 30 / 11.0, y + 4, 0},
                 {k * 30 / 11.0, y + 4, 0}, 0);
    maker.object(ObjectKind::kObject);
  }
  expect_bounds(maker.scene);
}

TEST_F(AdversarialBake, EdgesOfManyFacesAndPointsOfManyFans) {
  SceneMaker maker;
  for (int b = 0; b < 6; ++b) {
    const glm::dvec3 p(b * 9.0, 0, 0);
    for (int i = 0; i < 200; ++i)
      maker.triangle(p, p + glm::dvec3(0, 0, 6),
                     p + glm::dvec3(std::cos(i * 0.0314) * 4, std::sin(i * 0.0314) * 4, 2 + i % 3),
                     static_cast<std::uint16_t>(i % 2));
    for (int i = 0; i < 60; ++i) {  // cones tip to tip
      const glm::dvec3 tip = p + glm::dvec3(0, 12, 5);
      const auto at = [&](int k, double z) {
        return tip + glm::dvec3(std::cos(k * M_PI / 10), std::sin(k * M_PI / 10), z) * (1.0 + i / 20);
      };
      maker.triangle(tip, at(i % 20, 2), at(i % 20 + 1, 2), 0);
      maker.triangle(tip, at(i % 20 + 1, -2), at(i % 20, -2), 1);
    }
    maker.object(ObjectKind::kObject);
  }
  expect_bounds(maker.scene);
}

TEST_F(AdversarialBake, ThousandsOfLongTrianglesThroughEachOther) {
  std::mt19937_64 random(4);
  SceneMaker maker;
  for (int i = 0; i < 4000; ++i) {
    const glm::dvec3 p = random_point(random, 40);
    const glm::dvec3 q = p + random_direction(random) * 40.0;
    maker.triangle(p, q, p + random_direction(random) * 2.0, static_cast<std::uint16_t>(i % 4));
  }
  maker.object(ObjectKind::kObject);
  expect_bounds(maker.scene, 1000);
}

TEST_F(AdversarialBake, ThousandsOfLongTrianglesOnTopOfEachOther) {
  for (const bool flat : {true, false}) {
    std::mt19937_64 random(8);
    SceneMaker maker;
    for (int i = 0; i < (flat ? 4000 : 1500); ++i) {
      glm::dvec3 p = random_point(random, 4);
      glm::dvec3 q = p + random_direction(random) * 50.0;
      glm::dvec3 r = p + random_direction(random) * 30.0;
      if (flat) p.z = q.z = r.z = 0.001 * (i % 5);
      maker.triangle(p, q, r, static_cast<std::uint16_t>(i % 4));
    }
    maker.object(ObjectKind::kObject);
    expect_bounds(maker.scene, 1000);
  }
}

TEST_F(AdversarialBake, CitiesFarFromTheOrigin) {
  for (const glm::dvec3& corner : {glm::dvec3(1e6, -1e6, 100), glm::dvec3(-1e7, 1e7, 1e6)})
    expect_bounds(test::small_city(corner), 600, 0.1);
}

TEST_F(AdversarialBake, MillimetresBesideTensOfKilometres) {
  SceneMaker maker;
  maker.quad({-25000, -25000, 0}, {25000, -25000, 0}, {25000, 25000, 10}, {-25000, 25000, 0}, 2);
  maker.triangle({-25000, -20000, 500}, {25000, -21000, 900}, {20000, 25000, 700}, 3);
  maker.object(ObjectKind::kGround);
  for (int i = 0; i < 3000; ++i) {
    const glm::dvec3 p((i % 50) * 0.31, (i / 50) * 0.27, 1 + (i % 7) * 0.1);
    const double s = i % 3 == 0 ? 0.001 : i % 3 == 1 ? 0.006 : 0.1;
    maker.triangle(p, p + glm::dvec3(s, 0, 0), p + glm::dvec3(0, s, s), 0);
    if (i % 50 == 49) maker.object(ObjectKind::kObject);
  }
  expect_bounds(maker.scene, 400, 1.75);  // where two borders cross, each with steps of a metre
}

// From millimetres to a country: light is baked too, and the sun reaches what nothing stands over.
TEST_F(AdversarialBake, APlaneOfAMetreAPartOfMillimetresAndACountry) {
  // sky: of the mean of all corners of a node, at least.
  const auto expect_lit = [&](SceneMaker maker, double least_sky) {
    maker.object(ObjectKind::kObject);
    BakeOptions options;
    options.sun = SunAngles{145, 60};
    const auto report = bake_world(std::move(maker.scene), 0, options, folder_ / "lit");
    ASSERT_TRUE(report.ok()) << report.error().describe();
    EXPECT_GT(report->index.nodes.size(), 1U);
    std::vector<StoredNode> nodes;
    WorldIndex index;
    ASSERT_NO_FATAL_FAILURE(read_nodes(folder_ / "lit", nodes, index));
    for (const StoredNode& node : nodes) {
      double sky = 0;
      ASSERT_GT(node.light.size(), 0U);
      for (const gpu::TriangleLight& t : node.light)
        for (std::uint32_t k = 0; k < 3; ++k) sky += (t.sky >> 8 * k & 255U) / (255.0 * 3);
      EXPECT_GE(sky / static_cast<double>(node.light.size()), least_sky);
      if (least_sky < 0.999) continue;
      for (const gpu::TriangleLight& t : node.light) EXPECT_EQ(t.bounce >> 22U & 3U, gpu::kSunLit);
    }
  };
  SceneMaker plane;
  plane.quad({0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, 2);
  expect_lit(plane, 0.999);
  SceneMaker part;
  part.box({0, 0, 0}, {0.012, 0.012, 0.012});
  expect_lit(part, 0.99);
  SceneMaker country;
  const glm::dvec3 top(5e5, 5e5, 3000);
  const std::array<glm::dvec3, 4> rim = {{{0, 0, 0}, {1e6, 0, 0}, {1e6, 1e6, 0}, {0, 1e6, 0}}};
  for (std::size_t i = 0; i < 4; ++i) country.triangle(rim[i], rim[(i + 1) % 4], top, 2);
  expect_lit(country, 0.95);  // borders that are rounded to steps of metres hide a little
  SceneMaker cities;
  cities.houses({0, 0, 0}, 2, 23.3);
  cities.houses({1.8e6, 6.1e5, 0}, 2, 23.3);
  for (int i = 0; i < 50; ++i) {
    const glm::dvec3 p(1.8e6 + 0.37 * i, 6.1e5, 20);
    cities.box(p, p + glm::dvec3(0.01 * (i + 1), 0.02, 0.03));
  }
  expect_lit(cities, 0.5);
}

TEST_F(AdversarialBake, CoordinatesThatAreNoNumbersAreRefusedAndNameTheFault) {
  for (const double bad : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(),
                           -std::numeric_limits<double>::infinity(), 1e300, -1e300, 1e18}) {
    for (int axis = 0; axis < 3; ++axis) {
      Scene scene = test::small_city();
      scene.positions[scene.triangles[77][1]][axis] = bad;
      const auto report = bake(std::move(scene));
      ASSERT_FALSE(report.ok());
      EXPECT_NE(report.error().describe().find("lattice"), std::string::npos) << report.error().describe();
      EXPECT_FALSE(fs::exists(folder_ / "world"));
    }
  }
}

TEST_F(AdversarialBake, SpecksFarFromEverything) {
  SceneMaker maker;
  maker.terrain({0, 0, 0}, 20, 7.3);
  maker.houses({0, 0, 0}, 6, 23.3);
  for (const glm::dvec3& p :
       {glm::dvec3(9000, 0, 0), glm::dvec3(-7000, 8000, 50), glm::dvec3(100, -12000, 0), glm::dvec3(50, 50, 4000)}) {
    maker.box(p, p + glm::dvec3(0.5, 0.4, 0.3));
    maker.object(ObjectKind::kObject);
  }
  expect_bounds(maker.scene, 200, 0.6);
}

TEST_F(AdversarialBake, OneTriangle) {
  SceneMaker maker;
  maker.triangle({5e5, 4e6, 0}, {5e5 + 3, 4e6, 0}, {5e5, 4e6 + 2, 1}, 0);
  maker.object(ObjectKind::kObject);
  expect_bounds(maker.scene);
}

TEST_F(AdversarialBake, AllInOnePlane) {
  for (int axis = 0; axis < 3; ++axis) {
    std::mt19937_64 random(6);
    SceneMaker maker;
    for (int i = 0; i < 2000; ++i) {
      glm::dvec3 p = random_point(random, 60);
      glm::dvec3 q = p + random_direction(random) * 5.0;
      glm::dvec3 r = p + random_direction(random) * 3.0;
      p[axis] = q[axis] = r[axis] = 12.5;
      maker.triangle(p, q, r, static_cast<std::uint16_t>(i % 4));
      if (i % 40 == 39) maker.object(axis == 0 ? ObjectKind::kGround : ObjectKind::kObject);
    }
    expect_bounds(maker.scene, 400, 0.1);
  }
}

TEST_F(AdversarialBake, PolesRailsAndRailings) {
  SceneMaker maker;
  for (int i = 0; i < 12; ++i) {
    bar(maker, {i * 5.0, 0, 0}, {i * 5.0, 0, 6}, 0.05, 12);
    bar(maker, {i * 5.0, 0.02 * i, 5.5}, {i * 5.0 + 2, 0.5, 6.5}, 0.02, 6);
    maker.object(ObjectKind::kObject);
  }
  bar(maker, {0, 3, 0.1}, {90, 3, 0.1}, 0.03, 5);
  bar(maker, {0, 4.4, 0.1}, {90, 4.4, 0.1}, 0.03, 5);
  maker.object(ObjectKind::kObject);
  for (int i = 0; i < 60; ++i) bar(maker, {i * 0.15, 8, 0}, {i * 0.15, 8, 1}, 0.008, 8);
  bar(maker, {0, 8, 1}, {9, 8, 1}, 0.02, 8);
  maker.object(ObjectKind::kObject);
  expect_bounds(maker.scene);
}

TEST_F(AdversarialBake, ShellsInShells) {
  SceneMaker maker;
  for (int shell = 0; shell < 12; ++shell) {
    const double radius = 2 + 0.04 * shell;
    const auto at = [&](int i, int j) {
      const double a = i * M_PI / 9;
      const double b = j * M_PI / 9;
      return glm::dvec3(std::cos(a) * std::sin(b), std::sin(a) * std::sin(b), std::cos(b)) * radius;
    };
    for (int i = 0; i < 18; ++i)
      for (int j = 0; j < 9; ++j) maker.quad(at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j), 0);
    if (shell % 3 == 2) maker.object(ObjectKind::kObject);
  }
  expect_bounds(maker.scene);
}

TEST_F(AdversarialBake, MoebiusStrips) {
  SceneMaker maker;
  for (int strip = 0; strip < 8; ++strip) {
    const auto at = [&](int i, double w) {
      const double a = 2 * M_PI * i / 80;
      const double half = a * (1 + 2 * (strip % 3)) / 2;
      return glm::dvec3(strip * 9.0, 0, 4) + glm::dvec3(std::cos(a), std::sin(a), 0) * (3 + w * std::cos(half)) +
             glm::dvec3(0, 0, w * std::sin(half));
    };
    for (int i = 0; i < 80; ++i) maker.quad(at(i, -0.7), at(i, 0.7), at(i + 1, 0.7), at(i + 1, -0.7), 0);
    maker.object(ObjectKind::kObject);
  }
  expect_bounds(maker.scene);
}

TEST_F(AdversarialBake, FansOfThousandsOfTriangles) {
  for (const double height : {0.0, 7.0}) {
    SceneMaker maker;
    constexpr int kTriangles = 4000;
    const auto at = [&](int i) {
      const double a = 2 * M_PI * i / kTriangles;
      return glm::dvec3(std::cos(a) * 40, std::sin(a) * 40, height > 0 ? std::sin(17 * a) : 0);
    };
    for (int i = 0; i < kTriangles; ++i) maker.triangle({0, 0, height}, at(i), at(i + 1), 0);
    maker.object(ObjectKind::kObject);
    expect_bounds(maker.scene, 400, 0.1);
  }
}

}  // namespace
}  // namespace zc
