// SPDX-License-Identifier: GPL-3.0-or-later
// Reference systems against what surveys publish, and inputs that are scaled, turned, moved and converted.
#include <gtest/gtest.h>

#include <array>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include "baker/geo/earth_frame.h"
#include "baker/geo/reference_system.h"
#include "baker/import/shared/scene_builder.h"

namespace zc {
namespace {

using Kind = ReferenceSystem::Kind;

Geodetic place_of(const ReferenceSystem& system, const glm::dvec3& point) {
  const auto there = system.to_geocentric(point);
  EXPECT_TRUE(there.has_value()) << system.name();
  return geodetic_of(there.value_or(glm::dvec3(1, 0, 0)));
}

TEST(ReferenceSystem, NamesAreReadAsFilesWriteThem) {
  for (const char* name :
       {"EPSG:25832", "epsg:25832", "urn:ogc:def:crs:EPSG::25832", "http://www.opengis.net/def/crs/EPSG/0/25832",
        "urn:ogc:def:crs,crs:EPSG::25832,crs:EPSG::5783", "EPSG:25832+5783", "urn:adv:crs:ETRS89_UTM32*DE_DHHN92_NH"}) {
    const ReferenceSystem system(name);
    EXPECT_EQ(system.kind(), Kind::kProjected) << name;
    EXPECT_TRUE(system.is_metric() && system.is_same_as(ReferenceSystem("EPSG:25832"))) << name;
  }
  EXPECT_EQ(ReferenceSystem("EPSG:7415").kind(), Kind::kProjected);
  EXPECT_TRUE(ReferenceSystem("EPSG:7415").is_same_as(ReferenceSystem("EPSG:28992"))) << "with NAP heights";
  EXPECT_EQ(ReferenceSystem("EPSG:4978").kind(), Kind::kGeocentric);
  for (const char* name : {"EPSG:4326", "EPSG:6697", "EPSG:4979", "urn:ogc:def:crs:OGC:1.3:CRS84"})
    EXPECT_EQ(ReferenceSystem(name).kind(), Kind::kGeographic) << name;
  EXPECT_TRUE(ReferenceSystem("EPSG:4326").latitude_first());
  EXPECT_FALSE(ReferenceSystem("urn:ogc:def:crs:OGC:1.3:CRS84").latitude_first());
  EXPECT_FALSE(ReferenceSystem("EPSG:2263").is_metric()) << "feet";
  EXPECT_EQ(ReferenceSystem("").kind(), Kind::kNone);
  for (const char* name : {"EPSG:banana", "EPSG:0", "EPSG:99999999999999999999", "+proj=utm +zone=32", "local"})
    EXPECT_EQ(ReferenceSystem(name).kind(), Kind::kUnknown) << name;
}

TEST(ReferenceSystem, PlacesAreWhereSurveysSay) {
  // A zone's central meridian on the equator: EPSG Guidance Note 7-2.
  const Geodetic utm = place_of(ReferenceSystem("EPSG:32632"), {500000, 0, 0});
  EXPECT_NEAR(utm.lon_deg, 9, 1e-9);
  EXPECT_NEAR(utm.lat_deg, 0, 1e-9);
  // Amersfoort, the centre of the Dutch grid, by its ETRS89 coordinates: 52 9 18.62, 5 23 13.93.
  const Geodetic dutch = place_of(ReferenceSystem("EPSG:28992"), {155000, 463000, 0});
  EXPECT_NEAR(dutch.lat_deg, 52.155172, 1e-5);
  EXPECT_NEAR(dutch.lon_deg, 5.387203, 1e-5);
  // Sea level there is 43 m above the ellipsoid, in Tokyo 37 m.
  EXPECT_NEAR(dutch.height_m, 43.3, 1.5);
  EXPECT_NEAR(place_of(ReferenceSystem("EPSG:6697"), {35.68, 139.76, 10}).height_m, 47, 2);
  EXPECT_NEAR(place_of(ReferenceSystem("EPSG:4979"), {35.68, 139.76, 10}).height_m, 10, 1e-6);
  // Feet, in height too.
  const Geodetic york = place_of(ReferenceSystem("EPSG:2263"), {987000, 212000, 0});
  EXPECT_NEAR(york.lat_deg, 40.748, 0.01);
  EXPECT_NEAR(york.lon_deg, -73.988, 0.01);
}

TEST(ReferenceSystem, ThereAndBack) {
  const std::array<std::pair<const char*, glm::dvec3>, 5> points = {
      {{"EPSG:25832", {677000, 5405000, 420}},
       {"EPSG:7415", {85000, 446000, 3}},
       {"EPSG:4326", {48.7, 11.4, 300}},
       {"EPSG:2263", {987000, 212000, 30}},
       {"ENU of EPSG:4978 at lon 11.4200000, lat 48.7600000, h 370.000 m", {1200, -300, 12}}}};
  for (const auto& [name, point] : points) {
    const ReferenceSystem system(name);
    const auto there = system.to_geocentric(point);
    ASSERT_TRUE(there.has_value()) << name;
    const auto back = system.from_geocentric(*there);
    ASSERT_TRUE(back.has_value()) << name;
    EXPECT_LT(glm::distance(*back, point), 1e-3) << name;
  }
  EXPECT_FALSE(ReferenceSystem("EPSG:25832").to_geocentric({1e12, 1e12, 0}).has_value());
}

// A matrix for a city's part: exact in its middle, and 2 cm off at 500 m, which is the earth's curvature.
TEST(ReferenceSystem, AMatrixDoesForACitysPart) {
  for (const char* name : {"EPSG:25832", "EPSG:7415"}) {
    const ReferenceSystem system(name);
    const glm::dvec3 middle =
        system.name() == "EPSG:7415" ? glm::dvec3(85000, 446000, 3) : glm::dvec3(677000, 5405000, 420);
    const auto matrix = system.geocentric_at(middle);
    ASSERT_TRUE(matrix.has_value());
    EXPECT_LT(glm::distance(glm::dvec3((*matrix)[3]), *system.to_geocentric(middle)), 1e-9);
    const glm::dvec3 offset(400, -300, 50);
    EXPECT_LT(glm::distance(glm::dvec3(*matrix * glm::dvec4(offset, 1)), *system.to_geocentric(middle + offset)), 0.03);
    EXPECT_NEAR(glm::determinant(glm::dmat3(*matrix)), 1, 0.002);
  }
}

ObjectMesh triangle(const std::vector<glm::dvec3>& corners) {
  ObjectMesh mesh;
  mesh.id = "a";
  mesh.positions = corners;
  mesh.triangles = {{0, 1, 2}};
  mesh.materials = {0};
  return mesh;
}

// Adds a triangle as a file of the input `placement`, whose format has `up`, would.
Status add(SceneBuilder& builder, const Placement& placement, UpAxis up, const std::string& crs,
           const std::vector<glm::dvec3>& corners) {
  builder.placement().enter_input(placement);
  if (Status status = builder.placement().enter_file(up, "file"); !status.ok()) return status;
  if (Status status = builder.set_crs(crs, "file"); !status.ok()) return status;
  builder.material({});
  return builder.add(triangle(corners));
}

TEST(Placement, ScaleTurnAndOffsetInThisOrder) {
  SceneBuilder builder;
  Placement placement;
  placement.scale = 0.001;
  placement.up = UpAxis::kY;
  placement.offset_m = {100, 200, 300};
  ASSERT_TRUE(add(builder, placement, UpAxis::kZ, "", {{0, 0, 0}, {1000, 0, 0}, {0, 2000, 0}}).ok());
  const Scene scene = builder.finish({});
  ASSERT_EQ(scene.positions.size(), 3U);
  EXPECT_EQ(scene.positions[0], glm::dvec3(100, 200, 300));
  EXPECT_LT(glm::distance(scene.positions[1], glm::dvec3(101, 200, 300)), 1e-12);
  EXPECT_LT(glm::distance(scene.positions[2], glm::dvec3(100, 200, 302)), 1e-12);  // its y was up
}

// What glTF's importer has turned is turned back.
TEST(Placement, ZMayBeUpInAFormatOfYUp) {
  SceneBuilder builder;
  Placement placement;
  placement.up = UpAxis::kZ;
  const glm::dvec3 in_file(1, 2, 3);
  const glm::dvec3 as_imported(in_file.x, -in_file.z, in_file.y);
  ASSERT_TRUE(add(builder, placement, UpAxis::kY, "", {as_imported, {0, 0, 0}, {5, 0, 0}}).ok());
  EXPECT_EQ(builder.finish({}).positions[0], in_file);
}

TEST(Placement, InputsOfSeveralSystemsMeet) {
  const ReferenceSystem utm("EPSG:25832");
  const glm::dvec3 corner(677000, 5405000, 420);
  const std::vector<glm::dvec3> corners = {corner, corner + glm::dvec3(10, 0, 0), corner + glm::dvec3(0, 10, 0)};
  // The same triangle in degrees, in the next zone, and from the earth's centre.
  std::vector<glm::dvec3> degrees;
  std::vector<glm::dvec3> next_zone;
  std::vector<glm::dvec3> geocentric;
  for (const glm::dvec3& point : corners) {
    geocentric.push_back(*utm.to_geocentric(point));
    degrees.push_back(*ReferenceSystem("EPSG:4326").from_geocentric(geocentric.back()));
    next_zone.push_back(*ReferenceSystem("EPSG:25833").from_geocentric(geocentric.back()));
  }
  SceneBuilder builder;
  ASSERT_TRUE(add(builder, {}, UpAxis::kZ, "EPSG:25832", corners).ok());
  ASSERT_TRUE(add(builder, {}, UpAxis::kZ, "EPSG:25833", next_zone).ok());
  ASSERT_TRUE(add(builder, {}, UpAxis::kZ, "EPSG:4326", degrees).ok());
  Placement asked;
  asked.crs = "EPSG:4978";
  ASSERT_TRUE(add(builder, asked, UpAxis::kZ, "", geocentric).ok());
  const Scene scene = builder.finish({});
  EXPECT_EQ(scene.crs, "EPSG:25832");
  ASSERT_EQ(scene.positions.size(), 12U);
  for (std::size_t i = 3; i < 12; ++i) EXPECT_LT(glm::distance(scene.positions[i], corners[i % 3]), 1e-3) << i;
}

TEST(Placement, AWorldOfDegreesIsALocalFrame) {
  SceneBuilder builder;
  ASSERT_TRUE(
      add(builder, {}, UpAxis::kZ, "EPSG:4979", {{48.7, 11.4, 370}, {48.7, 11.401, 370}, {48.701, 11.4, 370}}).ok());
  const Scene scene = builder.finish({});
  EXPECT_EQ(scene.crs, "ENU of EPSG:4978 at lon 11.4000000, lat 48.7000000, h 370.000 m");
  EXPECT_LT(glm::length(scene.positions[0]), 0.01);
  EXPECT_NEAR(scene.positions[1].x, 73.6, 0.2);
  EXPECT_NEAR(scene.positions[2].y, 111.2, 0.2);
}

TEST(Placement, TheCallersSystemCountsAndWhatCannotBeIsRefused) {
  const std::vector<glm::dvec3> corners = {{677000, 5405000, 0}, {677010, 5405000, 0}, {677000, 5405010, 0}};
  SceneBuilder builder;
  Placement asked;
  asked.crs = "EPSG:25832";
  ASSERT_TRUE(add(builder, asked, UpAxis::kZ, "EPSG:31468", corners).ok());
  const Status tiles = add(builder, asked, UpAxis::kZ, EarthFrame({11, 48, 0}).crs(), corners);
  ASSERT_FALSE(tiles.ok());
  EXPECT_NE(tiles.error().message.find("--crs EPSG:25832"), std::string::npos);
  const Status unknown = add(builder, {}, UpAxis::kZ, "Site grid of 1998", corners);
  ASSERT_FALSE(unknown.ok());
  EXPECT_NE(unknown.error().message.find("where 'Site grid of 1998' lies is not known"), std::string::npos);
  const Status off_earth = add(builder, {}, UpAxis::kZ, "EPSG:4326", {{148, 11, 0}, {48, 11, 0}, {48.1, 11, 0}});
  ASSERT_FALSE(off_earth.ok());
  EXPECT_NE(off_earth.error().message.find("latitude, longitude and height"), std::string::npos);
  EXPECT_EQ(builder.finish({}).crs, "EPSG:25832");
}

}  // namespace
}  // namespace zc
