// SPDX-License-Identifier: GPL-3.0-or-later
// i3dm: 3D Tiles 1.1, section 10 (instanced 3D model).
#include <cmath>
#include <numbers>

#include "baker/geo/earth_frame.h"
#include "tests/unit/baker/import/tiles/tiles_support.h"

namespace zc::test {
namespace {

class TileInstances : public Tiles {
 protected:
  Scene instances(const std::string& features, const std::string& binary) const {
    write("a.i3dm", i3dm(features, binary, model()));
    return shown(tileset(tile(moved(0, 0, 100) + "," + content("a.i3dm"))));
  }
  // The model: origin, 2 m along -y, 2 m along x, once z is up.
  static void expect_corners(const Scene& scene, std::size_t first, const glm::dvec3& origin, const glm::dvec3& second,
                             const glm::dvec3& third, double tolerance = 1e-6) {
    ASSERT_GE(scene.positions.size(), first + 3);
    EXPECT_LT(glm::distance(scene.positions[first], origin), tolerance);
    EXPECT_LT(glm::distance(scene.positions[first + 1], second), tolerance);
    EXPECT_LT(glm::distance(scene.positions[first + 2], third), tolerance);
  }
};

TEST_F(TileInstances, StandWhereThePositionsSay) {
  const Scene scene = instances(R"({"INSTANCES_LENGTH":2,"POSITION":{"byteOffset":0},"RTC_CENTER":[1000,0,0]})",
                                floats({1, 2, 3, -4, -5, -6}));
  ASSERT_EQ(scene.objects.size(), 2U);
  expect_corners(scene, 0, {1001, 2, 103}, {1001, 0, 103}, {1003, 2, 103});
  expect_corners(scene, 3, {996, -5, 94}, {996, -7, 94}, {998, -5, 94});
  EXPECT_EQ(scene.objects[1].id, "part_1");
}

TEST_F(TileInstances, QuantisedPositionsFillTheirVolume) {
  const Scene scene =
      instances(R"({"INSTANCES_LENGTH":2,"POSITION_QUANTIZED":{"byteOffset":0},"QUANTIZED_VOLUME_OFFSET":[10,20,30],)"
                R"("QUANTIZED_VOLUME_SCALE":[100,200,400]})",
                shorts({0, 0, 0, 65535, 13107, 52428}));
  expect_corners(scene, 0, {10, 20, 130}, {10, 18, 130}, {12, 20, 130});
  expect_corners(scene, 3, {110, 60, 450}, {110, 58, 450}, {112, 60, 450});
}

TEST_F(TileInstances, UpAndRightTurnAndScalesStretch) {
  // x goes to y, y goes to z, and so z to x.
  const std::string turned =
      R"("POSITION":{"byteOffset":0},"NORMAL_UP":{"byteOffset":12},"NORMAL_RIGHT":{"byteOffset":24})";
  const Scene plain = instances(R"({"INSTANCES_LENGTH":1,)" + turned + R"(,"SCALE":{"byteOffset":36}})",
                                floats({0, 0, 0, 0, 0, 1, 0, 1, 0, 3}));
  expect_corners(plain, 0, {0, 0, 100}, {0, 0, 94}, {0, 6, 100});
  const Scene stretched = instances(R"({"INSTANCES_LENGTH":1,)" + turned + R"(,"SCALE_NON_UNIFORM":{"byteOffset":36}})",
                                    floats({0, 0, 0, 0, 0, 1, 0, 1, 0, 5, 0.5, 9}));
  expect_corners(stretched, 0, {0, 0, 100}, {0, 0, 99}, {0, 10, 100});
  // A negative scale mirrors: the surface still faces where it did.
  const Scene mirrored =
      instances(R"({"INSTANCES_LENGTH":1,"POSITION":{"byteOffset":0},"SCALE_NON_UNIFORM":{"byteOffset":12}})",
                floats({0, 0, 0, -1, 1, 1}));
  EXPECT_GT(normal2(mirrored, 0).z, 0);
}

TEST_F(TileInstances, OctahedraAreDirections) {
  // (0.5, 0.5) is +z, (0.5, 1) is +y, (1, 0.5) is +x, the corners are -z.
  const Scene scene = instances(
      R"({"INSTANCES_LENGTH":2,"POSITION":{"byteOffset":0},"NORMAL_UP_OCT32P":{"byteOffset":24},)"
      R"("NORMAL_RIGHT_OCT32P":{"byteOffset":32}})",
      floats({0, 0, 0, 9, 0, 0}) + shorts({32768, 32768, 65535, 65535}) + shorts({32768, 65535, 65535, 32768}));
  expect_corners(scene, 0, {0, 0, 100}, {0, 0, 98}, {0, 2, 100}, 1e-3);
  expect_corners(scene, 3, {9, 0, 100}, {9, 0, 102}, {11, 0, 100}, 1e-3);
}

TEST_F(TileInstances, EastNorthUpStandsOnTheEllipsoid) {
  const Geodetic place{11.425, 48.765, 370};
  const glm::dvec3 center = geocentric_of(place);
  const std::string features =
      R"({"INSTANCES_LENGTH":1,"EAST_NORTH_UP":true,"POSITION":{"byteOffset":0},"RTC_CENTER":[)" +
      std::to_string(center.x) + "," + std::to_string(center.y) + "," + std::to_string(center.z) + "]}";
  write("a.i3dm", i3dm(features, floats({0, 0, 0}), model()));
  const Scene scene =
      shown(tileset(R"({"boundingVolume":{"sphere":[)" + std::to_string(center.x) + "," + std::to_string(center.y) +
                    "," + std::to_string(center.z) + R"(,9]},"geometricError":0,)" + content("a.i3dm") + "}"));
  expect_corners(scene, 0, {0, 0, 0}, {0, -2, 0}, {2, 0, 0}, 1e-3);
  // By itself it is at the same place.
  const auto alone = import(folder_ / "a.i3dm");
  ASSERT_TRUE(alone.ok()) << alone.error().describe();
  expect_corners(*alone, 0, {0, 0, 0}, {0, -2, 0}, {2, 0, 0}, 1e-3);
  EXPECT_EQ(alone->crs, scene.crs);
}

TEST_F(TileInstances, AModelInAFileOfItsOwnIsSharedByTiles) {
  std::filesystem::create_directories(folder_ / "m");
  write("m/tree.glb", model("", "tree"));
  const std::string features = R"({"INSTANCES_LENGTH":1,"POSITION":{"byteOffset":0}})";
  write("a.i3dm", i3dm(features, floats({1, 0, 0}), "m/tree.glb  ", 0));
  write("b.cmpt",
        packed("cmpt", i3dm(features, floats({2, 0, 0}), "m/tree.glb", 0) + b3dm(R"({"RTC_CENTER":[5,0,0]})"), {2}));
  const std::string both = tileset(tile(R"("contents":[{"uri":"a.i3dm"},{"uri":"b.cmpt"}])"));
  const Scene scene = shown(both);
  EXPECT_EQ(names(scene), (std::vector<std::string>{"part", "tree_0", "tree_1"}));
  expect_corners(scene, 0, {5, 0, 0}, {5, -2, 0}, {7, 0, 0});
  expect_corners(scene, 3, {1, 0, 0}, {1, -2, 0}, {3, 0, 0});
  expect_corners(scene, 6, {2, 0, 0}, {2, -2, 0}, {4, 0, 0});
  // An instanced model that is instances itself would never end.
  write("m/tree.glb", i3dm(features, floats({1, 0, 0}), "tree.glb", 0));
  expect_refused(both, "model of an i3dm is neither GLB nor glTF", "m/tree.glb");
}

TEST_F(TileInstances, DamagedTablesAreRefused) {
  const auto refused = [&](const std::string& features, const std::string& binary, const std::string& words) {
    write("a.i3dm", i3dm(features, binary, model()));
    expect_refused(tileset(tile(content("a.i3dm"))), words, "a.i3dm");
  };
  refused("{}", "", "no INSTANCES_LENGTH");
  refused(R"({"INSTANCES_LENGTH":1})", "", "neither POSITION");
  refused(R"({"INSTANCES_LENGTH":2,"POSITION":{"byteOffset":0}})", floats({0, 0, 0}), "POSITION reaches past");
  refused(R"({"INSTANCES_LENGTH":4294967295,"POSITION":{"byteOffset":0}})", floats({0, 0, 0}), "instances");
  refused(R"({"INSTANCES_LENGTH":1,"POSITION":{"byteOffset":0},"NORMAL_UP":{"byteOffset":0}})", floats({0, 0, 0}),
          "need each other");
  refused(R"({"INSTANCES_LENGTH":1,"POSITION_QUANTIZED":{"byteOffset":0}})", shorts({0, 0, 0}), "QUANTIZED_VOLUME");
  const std::string good = i3dm(R"({"INSTANCES_LENGTH":1,"POSITION":{"byteOffset":0}})", floats({0, 0, 0}), model());
  for (std::size_t length = 0; length < good.size(); ++length) {
    std::string cut = good.substr(0, length);
    const auto declared = static_cast<std::uint32_t>(length);
    if (length >= 12) std::memcpy(cut.data() + 8, &declared, 4);
    write("a.i3dm", cut);
    expect_refused(tileset(tile(content("a.i3dm"))), "", "a.i3dm");
  }
}

TEST_F(TileInstances, AllInstancesOfABakeAreBounded) {
  // 2048 instances of a model that instances itself 4096 times.
  std::string bin;
  for (const float value : {0.F, 0.F, 0.F, 0.F, 0.F, 2.F, 2.F, 0.F, 0.F}) append(bin, value);
  std::string nodes = R"({"mesh":0})";
  std::string roots = "0";
  for (int i = 1; i < 4096; ++i) {
    nodes += R"(,{"mesh":0})";
    roots += "," + std::to_string(i);
  }
  const std::string many = glb(R"({"asset":{"version":"2.0"},"scenes":[{"nodes":[)" + roots + R"(]}],"nodes":[)" +
                                   nodes + R"(],"meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],)" +
                                   R"("accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}],)" +
                                   R"("bufferViews":[{"buffer":0,"byteLength":36}],"buffers":[{"byteLength":36}]})",
                               bin);
  std::string positions;
  for (int i = 0; i < 2048; ++i) positions += floats({static_cast<float>(i), 0, 0});
  write("a.i3dm", i3dm(R"({"INSTANCES_LENGTH":2048,"POSITION":{"byteOffset":0}})", positions, many));
  const auto scene = import(folder_ / "a.i3dm");
  ASSERT_FALSE(scene.ok());
  EXPECT_NE(scene.error().message.find("may have 4194304 triangles"), std::string::npos) << scene.error().describe();
}

}  // namespace
}  // namespace zc::test
