// SPDX-License-Identifier: GPL-3.0-or-later
// What the import tests share: files in a folder of their own, areas and volumes of scenes, GLBs put together by hand.
#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <glm/geometric.hpp>
#include <initializer_list>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "baker/import/import.h"

namespace zc::test {

class ImportTest : public ::testing::Test {
 protected:
  void SetUp() override {
    const auto* info = ::testing::UnitTest::GetInstance()->current_test_info();
    folder_ = std::filesystem::temp_directory_path() /
              ("zonecast_" + std::string(info->test_suite_name()) + "_" + info->name() + std::to_string(::getpid()));
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  std::filesystem::path write(const std::string& name, std::string_view bytes) const {
    auto path = folder_ / name;
    std::ofstream(path, std::ios::binary).write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    return path;
  }
  static Result<Scene> import(const std::filesystem::path& path) {
    return import_inputs(std::span<const std::filesystem::path>(&path, 1));
  }
  Result<Scene> import_text(const std::string& name, std::string_view text) const { return import(write(name, text)); }

  std::filesystem::path folder_;
};

inline glm::dvec3 normal2(const Scene& scene, std::size_t t) {
  const auto& [a, b, c] = scene.triangles[t];
  return glm::cross(scene.positions[b] - scene.positions[a], scene.positions[c] - scene.positions[a]);
}

inline double area(const Scene& scene) {
  double sum = 0;
  for (std::size_t t = 0; t < scene.triangles.size(); ++t) sum += glm::length(normal2(scene, t)) / 2;
  return sum;
}

// Positive when a closed surface faces outwards.
inline double volume(const Scene& scene) {
  double sum = 0;
  const glm::dvec3 origin = scene.positions.front();
  for (const auto& [a, b, c] : scene.triangles)
    sum +=
        glm::dot(scene.positions[a] - origin, glm::cross(scene.positions[b] - origin, scene.positions[c] - origin)) / 6;
  return sum;
}

inline std::uint64_t noted(const Scene& scene, std::string_view words) {
  std::uint64_t count = 0;
  for (const ImportCount& note : scene.notes)
    if (note.what.find(words) != std::string::npos) count += note.count;
  return count;
}

// Objects cover all triangles in order; every index is in range.
inline void expect_whole(const Scene& scene) {
  std::uint32_t next = 0;
  for (const SceneObject& object : scene.objects) {
    EXPECT_EQ(object.first_triangle, next);
    EXPECT_GT(object.triangle_count, 0U);
    next += object.triangle_count;
  }
  EXPECT_EQ(next, scene.triangles.size());
  EXPECT_EQ(scene.triangle_material.size(), scene.triangles.size());
  for (const auto& triangle : scene.triangles)
    for (const std::uint32_t corner : triangle) ASSERT_LT(corner, scene.positions.size());
  for (const std::uint16_t material : scene.triangle_material) ASSERT_LT(material, scene.materials.size());
}

// What becomes of a damaged file.
inline void expect_whole_or_refused(const Result<Scene>& scene) {
  if (scene.ok())
    expect_whole(*scene);
  else
    EXPECT_EQ(scene.error().describe().find('\n'), std::string::npos);
}

// The folder of real city models, or an empty path where there is none.
inline std::filesystem::path data_folder() {
  if (const char* named = std::getenv("ZONECAST_DATA"); named != nullptr && *named != 0) return named;
  const auto beside = std::filesystem::path("../shared/data");
  return std::filesystem::exists(beside) ? beside : std::filesystem::path();
}

template <class T>
void append(std::string& bytes, const T& value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

inline std::string glb(std::string json, std::string bin) {
  while (json.size() % 4 != 0) json += ' ';
  while (bin.size() % 4 != 0) bin += '\0';
  std::string file = "glTF";
  append(file, std::uint32_t{2});
  append(file, static_cast<std::uint32_t>(12 + 8 + json.size() + (bin.empty() ? 0 : 8 + bin.size())));
  append(file, static_cast<std::uint32_t>(json.size()));
  append(file, std::uint32_t{0x4E4F534A});
  file += json;
  if (bin.empty()) return file;
  append(file, static_cast<std::uint32_t>(bin.size()));
  append(file, std::uint32_t{0x004E4942});
  return file + bin;
}

inline std::string floats(std::initializer_list<float> values) {
  std::string bytes;
  for (const float value : values) append(bytes, value);
  return bytes;
}

inline std::string shorts(std::initializer_list<std::uint16_t> values) {
  std::string bytes;
  for (const std::uint16_t value : values) append(bytes, value);
  return bytes;
}

}  // namespace zc::test
