// SPDX-License-Identifier: GPL-3.0-or-later
// What the tests of 3D Tiles share: tilesets and contents put together by the letter of the standard.
#pragma once

#include <initializer_list>
#include <string>
#include <vector>

#include "tests/unit/baker/import/import_support.h"

namespace zc::test {

inline constexpr const char* kBox = R"("boundingVolume":{"box":[0,0,0,1,0,0,0,1,0,0,0,1]},"geometricError":0)";

class Tiles : public ImportTest {
 protected:
  // One triangle of glTF's floor with its right angle at the origin and legs of 2 m along x and -y once z is up.
  static std::string model(const std::string& more = "", const std::string& name = "part") {
    std::string bin;
    for (const float value : {0.F, 0.F, 0.F, 0.F, 0.F, 2.F, 2.F, 0.F, 0.F}) append(bin, value);
    return glb(R"({"asset":{"version":"2.0"},)" + more + R"("scenes":[{"nodes":[0]}],"nodes":[{"mesh":0,"name":")" +
                   name + R"("}],"meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],)" +
                   R"("accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}],)" +
                   R"("bufferViews":[{"buffer":0,"byteLength":36}],"buffers":[{"byteLength":36}]})",
               bin);
  }
  static std::string packed(const char* kind, const std::string& body, std::initializer_list<std::uint32_t> words) {
    std::string file = kind;
    append(file, std::uint32_t{1});
    append(file, static_cast<std::uint32_t>(12 + 4 * words.size() + body.size()));
    for (const std::uint32_t word : words) append(file, word);
    return file + body;
  }
  static std::string b3dm(const std::string& features, const std::string& binary = "", const std::string& batch = "") {
    const auto size = [](const std::string& text) { return static_cast<std::uint32_t>(text.size()); };
    return packed("b3dm", features + binary + batch + model(), {size(features), size(binary), size(batch), 0});
  }
  static std::string tile(const std::string& more) { return std::string("{") + kBox + "," + more + "}"; }
  static std::string content(const std::string& name) { return R"("content":{"uri":")" + name + R"("})"; }
  static std::string tileset(const std::string& root, const std::string& asset = R"("version":"1.1")",
                             const std::string& more = "") {
    return R"({"asset":{)" + asset + R"(},"geometricError":9,)" + more + R"("root":)" + root + "}";
  }
  static std::string moved(double x, double y, double z) {
    return R"("transform":[1,0,0,0,0,1,0,0,0,0,1,0,)" + std::to_string(x) + "," + std::to_string(y) + "," +
           std::to_string(z) + ",1]";
  }
  // Feature table, its binary, then what comes behind: the model, or its URI.
  static std::string i3dm(const std::string& features, const std::string& binary, const std::string& body,
                          std::uint32_t format = 1) {
    const auto size = [](const std::string& text) { return static_cast<std::uint32_t>(text.size()); };
    return packed("i3dm", features + binary + body, {size(features), size(binary), 0, 0, format});
  }
  Scene shown(const std::string& json) const {
    auto scene = import_text("tileset.json", json);
    EXPECT_TRUE(scene.ok()) << scene.error().describe();
    if (!scene.ok()) return {};
    expect_whole(*scene);
    return *std::move(scene);
  }
  // One line says why, and names the file.
  void expect_refused(const std::string& json, const std::string& words,
                      const std::string& name = "tileset.json") const {
    const auto scene = import_text("tileset.json", json);
    ASSERT_FALSE(scene.ok()) << words;
    EXPECT_EQ(scene.error().path, (folder_ / name).string());
    EXPECT_NE(scene.error().message.find(words), std::string::npos) << scene.error().describe();
    EXPECT_EQ(scene.error().describe().find('\n'), std::string::npos);
  }
  static std::vector<std::string> names(const Scene& scene) {
    std::vector<std::string> all;
    for (const SceneObject& object : scene.objects) all.push_back(object.id);
    return all;
  }
};

}  // namespace zc::test
