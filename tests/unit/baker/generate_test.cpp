// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/generate/city.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <glm/vector_relational.hpp>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "base/file.h"

namespace zc {
namespace {

using Triangle = std::array<glm::dvec3, 3>;

struct Object {
  std::string name;
  std::vector<Triangle> triangles;  // z up
};

std::vector<std::byte> bytes_of(const std::filesystem::path& path) {
  auto bytes = read_file(path, 1ULL << 32U);
  EXPECT_TRUE(bytes.ok()) << path;
  return bytes.ok() ? std::move(bytes).value() : std::vector<std::byte>{};
}

std::uint32_t u32_at(const std::vector<std::byte>& bytes, std::size_t at) {
  std::uint32_t value = 0;
  std::memcpy(&value, bytes.data() + at, sizeof(value));
  return value;
}

std::filesystem::path fresh_folder(const std::string& name) {
  const auto dir = std::filesystem::temp_directory_path() / ("zonecast_generate_" + name);
  std::filesystem::remove_all(dir);
  return dir;
}

// One city for all tests that change nothing.
class GeneratedCity : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    // One process per case under ctest: the folder's name carries the case's.
    dir_ = fresh_folder(testing::UnitTest::GetInstance()->current_test_suite()->name() + std::to_string(::getpid()));
    auto report = generate_city({1, 0.5}, dir_);
    ASSERT_TRUE(report.ok()) << report.error().describe();
    report_ = *report;
    load();
  }
  static void TearDownTestSuite() {
    std::filesystem::remove_all(dir_);
    objects_.clear();
  }

  static void load() {
    const std::vector<std::byte> glb = bytes_of(dir_ / "city.glb");
    ASSERT_EQ(u32_at(glb, 8), glb.size());
    const std::size_t json_bytes = u32_at(glb, 12);
    const auto* text = reinterpret_cast<const char*>(glb.data()) + 20;
    const auto json = nlohmann::json::parse(text, text + json_bytes);
    const std::size_t bin = 20 + json_bytes + 8;
    const auto start = [&](const nlohmann::json& accessor) {
      const auto& view = json["bufferViews"][accessor["bufferView"].get<std::size_t>()];
      return bin + view["byteOffset"].get<std::size_t>() + accessor["byteOffset"].get<std::size_t>();
    };
    for (const auto& node : json["nodes"]) {
      Object object{node["name"], {}};
      for (const auto& primitive : json["meshes"][node["mesh"].get<std::size_t>()]["primitives"]) {
        const auto& positions = json["accessors"][primitive["attributes"]["POSITION"].get<std::size_t>()];
        const auto& indices = json["accessors"][primitive["indices"].get<std::size_t>()];
        ASSERT_LT(primitive["material"].get<std::size_t>(), json["materials"].size());
        const std::size_t count = indices["count"];
        for (std::size_t i = 0; i < count; i += 3) {
          Triangle t;
          for (std::size_t k = 0; k < 3; ++k) {
            const std::uint32_t index = u32_at(glb, start(indices) + 4 * (i + k));
            ASSERT_LT(index, positions["count"].get<std::uint32_t>()) << object.name;
            std::array<float, 3> p{};
            for (std::size_t axis = 0; axis < 3; ++axis) {
              p[axis] = std::bit_cast<float>(u32_at(glb, start(positions) + 12 * index + 4 * axis));
            }
            t[k] = {p[0], -p[2], p[1]};
          }
          object.triangles.push_back(t);
        }
      }
      objects_.push_back(std::move(object));
    }
  }

  static inline std::filesystem::path dir_;
  static inline GenerateReport report_;
  static inline std::vector<Object> objects_;
};

std::vector<std::vector<double>> drive_rows(const std::filesystem::path& path) {
  std::ifstream in(path);
  std::string line;
  std::getline(in, line);
  EXPECT_EQ(line, "time_s,eye_x,eye_y,eye_z,target_x,target_y,target_z,fov_y_deg");
  std::vector<std::vector<double>> rows;
  while (std::getline(in, line)) {
    std::stringstream cells(line);
    std::string cell;
    rows.emplace_back();
    while (std::getline(cells, cell, ',')) rows.back().push_back(std::stod(cell));
  }
  return rows;
}

// Whether the open segment a-b passes through the triangle (Moeller & Trumbore 1997).
bool crosses(glm::dvec3 a, glm::dvec3 b, const Triangle& t) {
  const glm::dvec3 e1 = t[1] - t[0], e2 = t[2] - t[0], d = b - a;
  const glm::dvec3 p = glm::cross(d, e2);
  const double det = glm::dot(e1, p);
  if (std::abs(det) < 1e-12) return false;
  const glm::dvec3 s = a - t[0];
  const double u = glm::dot(s, p) / det;
  const glm::dvec3 q = glm::cross(s, e1);
  const double v = glm::dot(d, q) / det;
  const double along = glm::dot(e2, q) / det;
  return u >= 0 && v >= 0 && u + v <= 1 && along > 0 && along < 1;
}

const Object* blocker(const std::vector<Object>& objects, glm::dvec3 a, glm::dvec3 b) {
  const glm::dvec3 low = glm::min(a, b), high = glm::max(a, b);
  for (const Object& o : objects) {
    for (const Triangle& t : o.triangles) {
      const glm::dvec3 tl = glm::min(t[0], glm::min(t[1], t[2])), th = glm::max(t[0], glm::max(t[1], t[2]));
      if (glm::any(glm::lessThan(th, low)) || glm::any(glm::greaterThan(tl, high))) continue;
      if (crosses(a, b, t)) return &o;
    }
  }
  return nullptr;
}

bool starts_with(const std::string& text, const char* prefix) { return text.rfind(prefix, 0) == 0; }

using Key = std::array<std::int64_t, 3>;
Key key(glm::dvec3 p) { return {std::llround(p.x * 1000), std::llround(p.y * 1000), std::llround(p.z * 1000)}; }

// Edges that do not match exactly one edge that runs the other way, as pairs of millimetre positions.
std::vector<std::pair<Key, Key>> open_edges(const Object& o) {
  std::map<std::pair<Key, Key>, int> balance;
  for (const Triangle& t : o.triangles) {
    for (std::size_t k = 0; k < 3; ++k) {
      const Key a = key(t[k]), b = key(t[(k + 1) % 3]);
      if (a < b) {
        ++balance[{a, b}];
      } else {
        --balance[{b, a}];
      }
    }
  }
  std::vector<std::pair<Key, Key>> open;
  for (const auto& [edge, count] : balance) {
    if (count != 0) open.push_back(edge);
  }
  return open;
}

TEST_F(GeneratedCity, holds_every_triangle_and_object_that_it_reports) {
  std::uint64_t triangles = 0;
  std::set<std::string> names;
  for (const Object& o : objects_) {
    triangles += o.triangles.size();
    names.insert(o.name);
  }
  EXPECT_EQ(triangles, report_.triangles);
  EXPECT_EQ(objects_.size(), report_.objects);
  EXPECT_EQ(names.size(), objects_.size()) << "every object has a name of its own";
  EXPECT_GT(triangles, 60'000U);
}

TEST_F(GeneratedCity, names_every_landmark_in_its_shots_and_nothing_stands_before_the_camera) {
  const auto bytes = bytes_of(dir_ / "shots.json");
  const auto* text = reinterpret_cast<const char*>(bytes.data());
  const auto json = nlohmann::json::parse(text, text + bytes.size());
  std::set<std::string> names;
  for (const auto& shot : json["shots"]) {
    names.insert(shot["name"].get<std::string>());
    const auto at = [&](const char* which) { return glm::dvec3{shot[which][0], shot[which][1], shot[which][2]}; };
    const glm::dvec3 eye = at("eye"), target = at("target");
    const Object* hit = blocker(objects_, eye, eye + (target - eye) * 0.6);
    EXPECT_EQ(hit, nullptr) << shot["name"] << " is blocked by " << hit->name;
  }
  EXPECT_EQ(names, (std::set<std::string>{"tire_shop", "underpass", "warehouse", "mirror_window", "plaza", "bridge"}));
}

TEST_F(GeneratedCity, drives_above_the_road_and_through_nothing) {
  const auto rows = drive_rows(dir_ / "drive.csv");
  ASSERT_GE(rows.size(), 600U);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    ASSERT_EQ(rows[i].size(), 8U);
    for (const double v : rows[i]) ASSERT_TRUE(std::isfinite(v));
    EXPECT_NEAR(rows[i][0], static_cast<double>(i) / 30, 1e-5);
    EXPECT_GT(rows[i][3], 1.0);
  }
  for (std::size_t i = 0; i + 20 < rows.size(); i += 20) {
    for (const double side : {-0.5, 0.0, 0.5}) {
      const auto eye = [&](std::size_t k) { return glm::dvec3{rows[k][1] + side, rows[k][2] + side, rows[k][3]}; };
      const Object* hit = blocker(objects_, eye(i), eye(i + 20));
      ASSERT_EQ(hit, nullptr) << "sample " << i << " runs through " << hit->name;
    }
  }
}

TEST_F(GeneratedCity, closes_every_building_but_for_its_base) {
  int checked = 0;
  for (const Object& o : objects_) {
    if (!starts_with(o.name, "building_") && o.name != "mirror_window" && o.name != "tire_shop") continue;
    ++checked;
    for (const auto& [a, b] : open_edges(o)) {
      ASSERT_TRUE(a[2] == 50 && b[2] == 50) << o.name << " is open at " << a[0] << " " << a[1] << " " << a[2] << " - "
                                            << b[0] << " " << b[1] << " " << b[2];
    }
  }
  EXPECT_GT(checked, 100);
}

TEST_F(GeneratedCity, turns_the_faces_of_closed_things_outward) {
  for (const Object& o : objects_) {
    if (!open_edges(o).empty()) continue;
    double volume = 0;
    const glm::dvec3 c = o.triangles[0][0];
    for (const Triangle& t : o.triangles) volume += glm::dot(t[0] - c, glm::cross(t[1] - c, t[2] - c)) / 6;
    EXPECT_GT(volume, 0) << o.name;
  }
}

TEST_F(GeneratedCity, covers_the_ground_once_and_facing_up) {
  double area = 0;
  double low = 0, high = 0;
  for (const Object& o : objects_) {
    if (!starts_with(o.name, "road_") && !starts_with(o.name, "sidewalk_") && !starts_with(o.name, "ground_") &&
        !starts_with(o.name, "bridge_ramp")) {
      continue;
    }
    for (const Triangle& t : o.triangles) {
      const glm::dvec3 n = glm::cross(t[1] - t[0], t[2] - t[0]);
      ASSERT_GE(n.z, -1e-6) << o.name;
      if (o.name != "bridge_ramp_north" && o.name != "bridge_ramp_south") area += n.z / 2;
      for (const glm::dvec3 p : t) {
        low = std::min(low, p.x);
        high = std::max(high, p.x);
      }
    }
    if (starts_with(o.name, "bridge_ramp")) {
      for (const Triangle& t : o.triangles) area += glm::cross(t[1] - t[0], t[2] - t[0]).z / 2;
    }
  }
  EXPECT_NEAR(area, (high - low) * (high - low), 1e-6 * area);
}

TEST(GenerateCity, yields_the_same_bytes_for_the_same_seed_and_others_for_another) {
  const auto pid = std::to_string(::getpid());
  const auto a = fresh_folder("a" + pid), b = fresh_folder("b" + pid), c = fresh_folder("c" + pid);
  ASSERT_TRUE(generate_city({7, 0.3}, a).ok());
  ASSERT_TRUE(generate_city({7, 0.3}, b).ok());
  ASSERT_TRUE(generate_city({8, 0.3}, c).ok());
  for (const char* file : {"city.glb", "drive.csv", "shots.json"})
    EXPECT_EQ(bytes_of(a / file), bytes_of(b / file)) << file;
  EXPECT_NE(bytes_of(a / "city.glb"), bytes_of(c / "city.glb"));
  for (const auto& dir : {a, b, c}) std::filesystem::remove_all(dir);
}

TEST(GenerateCity, refuses_a_size_out_of_range_and_a_folder_that_cannot_be) {
  const auto dir = fresh_folder("bad" + std::to_string(::getpid()));
  for (const double size_km : {0.0, 0.09, 20.5, -1.0, std::nan("")}) {
    const auto report = generate_city({1, size_km}, dir);
    ASSERT_FALSE(report.ok());
    EXPECT_EQ(report.error().code, ErrorCode::kArgument);
  }
  EXPECT_FALSE(std::filesystem::exists(dir));
  { std::ofstream(dir) << "a file"; }
  const auto report = generate_city({1, 0.3}, dir / "below");
  ASSERT_FALSE(report.ok());
  EXPECT_EQ(report.error().code, ErrorCode::kIo);
  std::filesystem::remove_all(dir);
}

}  // namespace
}  // namespace zc
