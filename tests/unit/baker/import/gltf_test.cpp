// SPDX-License-Identifier: GPL-3.0-or-later
#include <draco/compression/encode.h>
#include <draco/mesh/triangle_soup_mesh_builder.h>
#include <meshoptimizer.h>

#include "tests/unit/baker/import/import_support.h"

namespace zc::test {
namespace {

class Gltf : public ImportTest {
 protected:
  // One indexed triangle in the xz plane (the floor of glTF), facing up.
  static std::string triangle_bin() { return floats({0, 0, 0, 0, 0, 2, 2, 0, 0}) + shorts({0, 1, 2}); }
  static std::string triangle_json(const std::string& node = R"("mesh":0)", const std::string& more = "") {
    return R"({"asset":{"version":"2.0"},)" + more + R"("scene":0,"scenes":[{"nodes":[0]}],"nodes":[{)" + node +
           R"(}],"meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1,"material":0}]}],)"
           R"("materials":[{"name":"paint","pbrMetallicRoughness":{"baseColorFactor":[0.5,0.25,1,1],"metallicFactor":0,"roughnessFactor":0.5}}],)"
           R"("accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"},{"bufferView":1,"componentType":5123,"count":3,"type":"SCALAR"}],)"
           R"("bufferViews":[{"buffer":0,"byteLength":36},{"buffer":0,"byteOffset":36,"byteLength":6}],"buffers":[{"byteLength":42}]})";
  }
  // A 6 × 6 bumpy grid.
  static std::string draco_stream(int method) {
    constexpr int kSide = 6;
    draco::TriangleSoupMeshBuilder builder;
    builder.Start(2 * kSide * kSide);
    const int position = builder.AddAttribute(draco::GeometryAttribute::POSITION, 3, draco::DT_FLOAT32);
    int face = 0;
    const auto point = [](int x, int y) {
      return std::array{static_cast<float>(x), static_cast<float>((x * y) % 3), static_cast<float>(y)};
    };
    for (int x = 0; x < kSide; ++x)
      for (int y = 0; y < kSide; ++y) {
        const auto a = point(x, y), b = point(x, y + 1), c = point(x + 1, y + 1), d = point(x + 1, y);
        builder.SetAttributeValuesForFace(position, draco::FaceIndex(static_cast<std::uint32_t>(face++)), a.data(),
                                          b.data(), c.data());
        builder.SetAttributeValuesForFace(position, draco::FaceIndex(static_cast<std::uint32_t>(face++)), a.data(),
                                          c.data(), d.data());
      }
    const auto mesh = builder.Finalize();
    draco::Encoder encoder;
    encoder.SetEncodingMethod(method);
    encoder.SetAttributeQuantization(draco::GeometryAttribute::POSITION, 14);
    draco::EncoderBuffer buffer;
    EXPECT_TRUE(encoder.EncodeMeshToBuffer(*mesh, &buffer).ok());
    return {buffer.data(), buffer.size()};
  }
  static std::string draco_glb(const std::string& stream) {
    const std::string length = std::to_string(stream.size());
    return glb(
        R"({"asset":{"version":"2.0"},"extensionsUsed":["KHR_draco_mesh_compression"],"extensionsRequired":["KHR_draco_mesh_compression"],)"
        R"("scenes":[{"nodes":[0]}],"nodes":[{"mesh":0,"name":"Ground_tile"}],"meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1,)"
        R"("extensions":{"KHR_draco_mesh_compression":{"bufferView":0,"attributes":{"POSITION":0}}}}]}],)"
        R"("accessors":[{"componentType":5126,"count":49,"type":"VEC3"},{"componentType":5125,"count":216,"type":"SCALAR"}],)"
        R"("bufferViews":[{"buffer":0,"byteLength":)" +
            length + R"(}],"buffers":[{"byteLength":)" + length + "}]}",
        stream);
  }
};

TEST_F(Gltf, NodeTransformsApplyAndYUpBecomesZUp) {
  const auto scene = import_text(
      "node.glb", glb(triangle_json(R"("name":"house","mesh":0,"translation":[1000000,20,-3000000],"scale":[2,2,2])"),
                      triangle_bin()));
  ASSERT_TRUE(scene.ok()) << scene.error().describe();
  expect_whole(*scene);
  ASSERT_EQ(scene->triangles.size(), 1U);
  EXPECT_EQ(scene->positions[0], glm::dvec3(1000000, 3000000, 20));
  EXPECT_EQ(scene->positions[1], glm::dvec3(1000000, 2999996, 20));
  EXPECT_EQ(scene->positions[2], glm::dvec3(1000004, 3000000, 20));
  EXPECT_GT(normal2(*scene, 0).z, 0);
  EXPECT_EQ(scene->objects[0].id, "house");
  EXPECT_EQ(scene->objects[0].kind, ObjectKind::kObject);
  EXPECT_EQ(scene->materials[0].name, "paint");
  EXPECT_EQ(scene->materials[0].base_color, glm::vec3(0.5F, 0.25F, 1));
  EXPECT_FLOAT_EQ(scene->materials[0].roughness, 0.5F);
}

TEST_F(Gltf, MirroringKeepsTrianglesFacingOut) {
  const auto scene = import_text("mirror.glb", glb(triangle_json(R"("mesh":0,"scale":[-1,1,1])"), triangle_bin()));
  ASSERT_TRUE(scene.ok()) << scene.error().describe();
  EXPECT_GT(normal2(*scene, 0).z, 0);
  EXPECT_EQ(scene->objects[0].id, "node_0");
}

TEST_F(Gltf, EveryPrefixOfAGlbIsAnErrorOfOneLine) {
  const std::string file = glb(triangle_json(), triangle_bin());
  ASSERT_TRUE(import_text("whole.glb", file).ok());
  for (std::size_t length = 0; length < file.size(); ++length) {
    const auto scene = import_text("cut.glb", std::string_view(file).substr(0, length));
    ASSERT_FALSE(scene.ok()) << length;
    EXPECT_EQ(scene.error().message.find('\n'), std::string::npos);
    if (length >= 20) {
      EXPECT_EQ(scene.error().byte_offset, static_cast<std::int64_t>(length));
    }
  }
}

// The declared length patched to fit: what lies behind the header must hold up by itself.
TEST_F(Gltf, EveryShortenedGlbAndEveryChangedByteEndsWithoutACrash) {
  const std::string file = glb(triangle_json(), triangle_bin());
  for (std::size_t length = 12; length < file.size(); ++length) {
    std::string cut = file.substr(0, length);
    const auto declared = static_cast<std::uint32_t>(length);
    std::memcpy(cut.data() + 8, &declared, 4);
    EXPECT_FALSE(import_text("cut.glb", cut).ok()) << length;
  }
  for (std::size_t at = 0; at < file.size(); ++at)
    for (const char value : {'\0', '9', '"', '\xFF'}) {
      std::string changed = file;
      changed[at] = value;
      const auto scene = import_text("changed.glb", changed);
      if (scene.ok()) expect_whole(*scene);
    }
}

TEST_F(Gltf, DracoPrimitivesOfBothMethodsDecode) {
  for (const int method : {draco::MESH_SEQUENTIAL_ENCODING, draco::MESH_EDGEBREAKER_ENCODING}) {
    const auto scene = import_text("draco.glb", draco_glb(draco_stream(method)));
    ASSERT_TRUE(scene.ok()) << scene.error().describe();
    expect_whole(*scene);
    EXPECT_EQ(scene->triangles.size(), 72U);
    EXPECT_EQ(scene->positions.size(), 49U);
    EXPECT_EQ(scene->objects[0].kind, ObjectKind::kGround);  // by name
    for (std::size_t t = 0; t < scene->triangles.size(); ++t) EXPECT_GT(normal2(*scene, t).z, 0);
  }
}

TEST_F(Gltf, DamagedDracoStreamsEndWithoutACrash) {
  for (const int method : {draco::MESH_SEQUENTIAL_ENCODING, draco::MESH_EDGEBREAKER_ENCODING}) {
    const std::string stream = draco_stream(method);
    for (std::size_t length = 1; length + 1 < stream.size(); ++length) {
      const auto scene = import_text("cut.glb", draco_glb(stream.substr(0, length)));
      if (scene.ok()) expect_whole(*scene);  // padding at the end may be missed by nothing
    }
    for (std::size_t at = 0; at < stream.size(); ++at)
      for (const char value : {'\0', '\x7F', '\xFF'}) {
        std::string changed = stream;
        changed[at] = value;
        const auto scene = import_text("changed.glb", draco_glb(changed));
        if (scene.ok()) expect_whole(*scene);
      }
    std::string swollen = stream;
    const std::size_t counts = method == draco::MESH_SEQUENTIAL_ENCODING ? 11 : 12;
    swollen.replace(counts, 4, "\xFF\xFF\xFF\x7F");
    EXPECT_FALSE(import_text("swollen.glb", draco_glb(swollen)).ok());
  }
}

TEST_F(Gltf, QuantisedStripsAndMissingIndicesAreRead) {
  // Normalised bytes with a stride of four: a unit square as a strip.
  std::string bin;
  for (const auto& [x, z] : {std::pair{0, 0}, {0, 127}, {127, 0}, {127, 127}})
    bin += {static_cast<char>(x), 0, static_cast<char>(z), 0};
  const auto scene = import_text(
      "strip.glb",
      glb(R"({"asset":{"version":"2.0"},"extensionsRequired":["KHR_mesh_quantization"],"nodes":[{"mesh":0,"rotation":[0,0.70710678118654752,0,0.70710678118654752]}],)"
          R"("meshes":[{"primitives":[{"attributes":{"POSITION":0},"mode":5},{"attributes":{"POSITION":0},"mode":1}]}],)"
          R"("accessors":[{"bufferView":0,"componentType":5120,"normalized":true,"count":4,"type":"VEC3"}],)"
          R"("bufferViews":[{"buffer":0,"byteLength":16,"byteStride":4}],"buffers":[{"byteLength":16}]})",
          bin));
  ASSERT_TRUE(scene.ok()) << scene.error().describe();
  EXPECT_EQ(scene->triangles.size(), 2U);
  EXPECT_NEAR(area(*scene), 1.0, 1e-12);
  for (std::size_t t = 0; t < 2; ++t) EXPECT_GT(normal2(*scene, t).z, 0);
  EXPECT_EQ(noted(*scene, "without triangles"), 1U);
}

// Two triangles of one colour each, and one whose corners differ; times the material's.
TEST_F(Gltf, VertexColoursBecomeTheTrianglesMaterials) {
  std::string bin = floats({0, 0, 0, 0, 0, 2, 2, 0, 0, 5, 0, 0, 5, 0, 2, 7, 0, 0, 9, 0, 0, 9, 0, 2, 11, 0, 0});
  const std::size_t colors = bin.size();
  for (const auto& [r, g, b] : std::array<std::array<int, 3>, 9>{{{255, 0, 51},
                                                                  {255, 0, 51},
                                                                  {255, 0, 51},
                                                                  {0, 102, 0},
                                                                  {0, 102, 0},
                                                                  {0, 102, 0},
                                                                  {255, 0, 0},
                                                                  {0, 255, 0},
                                                                  {0, 0, 255}}})
    for (const int v : {r, g, b, 255}) bin.push_back(static_cast<char>(v));
  const std::string json =
      R"({"asset":{"version":"2.0"},"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],)"
      R"("meshes":[{"primitives":[{"attributes":{"POSITION":0,"COLOR_0":1},"material":0}]}],)"
      R"("materials":[{"name":"paint","pbrMetallicRoughness":{"baseColorFactor":[0.5,1,1,1],"roughnessFactor":0.25}}],)"
      R"("accessors":[{"bufferView":0,"componentType":5126,"count":9,"type":"VEC3"},)"
      R"({"bufferView":1,"componentType":5121,"normalized":true,"count":9,"type":"VEC4"}],)"
      R"("bufferViews":[{"buffer":0,"byteLength":)" +
      std::to_string(colors) + R"(},{"buffer":0,"byteOffset":)" + std::to_string(colors) +
      R"(,"byteLength":36}],"buffers":[{"byteLength":)" + std::to_string(bin.size()) + "}]}";
  const auto scene = import_text("colors.glb", glb(json, bin));
  ASSERT_TRUE(scene.ok()) << scene.error().describe();
  ASSERT_EQ(scene->triangles.size(), 3U);
  const auto color = [&](std::size_t t) { return scene->materials[scene->triangle_material[t]].base_color; };
  EXPECT_LT(glm::distance(color(0), glm::vec3(0.5F, 0, 0.2F)), 1e-5F);
  EXPECT_LT(glm::distance(color(1), glm::vec3(0, 0.4F, 0)), 1e-5F);
  EXPECT_LT(glm::distance(color(2), glm::vec3(0.5F / 3, 1.0F / 3, 1.0F / 3)), 0.03F);
  EXPECT_FLOAT_EQ(scene->materials[scene->triangle_material[2]].roughness, 0.25F);
  const std::string short_of = json.substr(0, json.find(R"("count":9,"type":"VEC4")")) + R"("count":8,"type":"VEC4")" +
                               json.substr(json.find(R"("count":9,"type":"VEC4")") + 23);
  const auto refused = import_text("few.glb", glb(short_of, bin));
  ASSERT_FALSE(refused.ok());
  EXPECT_NE(refused.error().message.find("not as many colours"), std::string::npos) << refused.error().message;
}

TEST_F(Gltf, SparseAccessorsReplaceElements) {
  std::string bin = triangle_bin() + std::string(2, '\0') + shorts({1, 0}) + floats({0, 0, 8});
  std::string json = triangle_json();
  const auto put = [&](std::string_view from, std::string_view to) { json.replace(json.find(from), from.size(), to); };
  put(R"("count":3,"type":"VEC3")",
      R"("count":3,"type":"VEC3","sparse":{"count":1,"indices":{"bufferView":2,"componentType":5123},"values":{"bufferView":3}})");
  put(R"("byteOffset":36,"byteLength":6})",
      R"("byteOffset":36,"byteLength":6},{"buffer":0,"byteOffset":44,"byteLength":2},{"buffer":0,"byteOffset":48,"byteLength":12})");
  put(R"("buffers":[{"byteLength":42}])", R"("buffers":[{"byteLength":60}])");
  const auto scene = import_text("sparse.glb", glb(json, bin));
  ASSERT_TRUE(scene.ok()) << scene.error().describe();
  EXPECT_DOUBLE_EQ(area(*scene), 8.0);
}

TEST_F(Gltf, ExternalBuffersAreReadAndMissingImagesNoted) {
  write("mesh data.bin", triangle_bin());
  std::string json = triangle_json(R"("mesh":0)", R"("images":[{"uri":"none.png"}],"textures":[{"source":0}],)");
  json.replace(json.find(R"([{"byteLength":42}])"), 19, R"([{"byteLength":42,"uri":"mesh%20data.bin"}])");
  json.replace(json.find(R"("metallicFactor")"), 0, R"("baseColorTexture":{"index":0},)");
  const auto scene = import_text("model.gltf", json);
  ASSERT_TRUE(scene.ok()) << scene.error().describe();
  EXPECT_EQ(noted(*scene, "missing texture"), 1U);
  EXPECT_EQ(scene->materials[0].base_color, glm::vec3(0.5F, 0.25F, 1));
  std::filesystem::remove(folder_ / "mesh data.bin");
  EXPECT_FALSE(import(folder_ / "model.gltf").ok());
}

TEST_F(Gltf, NoUriLeadsOutOfTheFolder) {
  std::filesystem::create_directories(folder_ / "in/a");
  write("secret.bin", triangle_bin());
  write("in/a/secret.bin", triangle_bin());
  const auto with_buffer = [&](const std::string& uri) {
    std::string json = triangle_json();
    json.replace(json.find(R"([{"byteLength":42}])"), 19, R"([{"byteLength":42,"uri":")" + uri + R"("}])");
    return import(write("in/model.gltf", json));
  };
  EXPECT_TRUE(with_buffer("a/../a/secret.bin").ok());
  for (const std::string& uri :
       {std::string("../secret.bin"), (folder_ / "secret.bin").string(), (folder_ / "in/a/secret.bin").string(),
        std::string("%2e%2e/secret.bin"), std::string("..%2fsecret.bin"), std::string("a%2Fsecret.bin"),
        std::string("a/secret.bin%00"), "file://" + (folder_ / "secret.bin").string()}) {
    const auto scene = with_buffer(uri);
    ASSERT_FALSE(scene.ok()) << uri;
    EXPECT_EQ(scene.error().code, ErrorCode::kUnsupported) << scene.error().describe();
  }
  // An image there is like a missing one.
  for (const std::string& uri : {std::string("../secret.bin"), (folder_ / "secret.bin").string()}) {
    std::string json =
        triangle_json(R"("mesh":0)", R"("images":[{"uri":")" + uri + R"("}],"textures":[{"source":0}],)");
    json.replace(json.find(R"("metallicFactor")"), 0, R"("baseColorTexture":{"index":0},)");
    const auto scene = import(write("in/painted.glb", glb(json, triangle_bin())));
    ASSERT_TRUE(scene.ok()) << scene.error().describe();
    ASSERT_EQ(scene->notes.size(), 1U);
    EXPECT_EQ(noted(*scene, "outside the folder"), 1U);
    EXPECT_EQ(scene->notes[0].names, std::vector{uri});
  }
}

TEST_F(Gltf, TextureColourIsTheMeanInLinearLight) {
  // A black and a white pixel: 0.5 in linear light, 0.21 if the mean were taken of the stored values.
  const std::string png =
      "data:image/png;base64,"
      "iVBORw0KGgoAAAANSUhEUgAAAAIAAAABCAIAAAB7QOjdAAAAD0lEQVR4nGNg"
      "YGD4//8/AAYBAv4CsjmuAAAAAElFTkSuQmCC";
  std::string json = triangle_json(R"("mesh":0)", R"("images":[{"uri":")" + png + R"("}],"textures":[{"source":0}],)");
  json.replace(json.find(R"("metallicFactor")"), 0, R"("baseColorTexture":{"index":0},)");
  const auto scene = import_text("painted.glb", glb(json, triangle_bin()));
  ASSERT_TRUE(scene.ok()) << scene.error().describe();
  EXPECT_TRUE(scene->notes.empty());
  EXPECT_EQ(scene->materials[0].base_color, glm::vec3(0.25F, 0.125F, 0.5F));
}

TEST_F(Gltf, TextureCoordinatesAreMovedAsTheMaterialSays) {
  const std::string png =
      "data:image/png;base64,"
      "iVBORw0KGgoAAAANSUhEUgAAAAIAAAABCAIAAAB7QOjdAAAAD0lEQVR4nGNg"
      "YGD4//8/AAYBAv4CsjmuAAAAAElFTkSuQmCC";
  std::string json = triangle_json(
      R"("mesh":0)", R"("images":[{"uri":")" + png +
                         R"("}],"samplers":[{"wrapS":33071,"wrapT":33648}],"textures":[{"source":0,"sampler":0}],)");
  const auto replace = [&](const std::string& what, const std::string& with) {
    json.replace(json.find(what), what.size(), with);
  };
  // A quarter turn, twice as wide, then moved.
  replace(
      R"("metallicFactor")",
      R"("baseColorTexture":{"index":0,"extensions":{"KHR_texture_transform":{"offset":[10,20],"rotation":1.5707963267948966,"scale":[2,1]}}},"metallicFactor")");
  replace(R"("POSITION":0)", R"("POSITION":0,"TEXCOORD_0":2)");
  replace(
      R"("count":3,"type":"SCALAR"})",
      R"("count":3,"type":"SCALAR"},{"bufferView":2,"componentType":5123,"normalized":true,"count":3,"type":"VEC2"})");
  replace(R"("byteOffset":36,"byteLength":6})",
          R"("byteOffset":36,"byteLength":6},{"buffer":0,"byteOffset":44,"byteLength":12})");
  replace(R"("byteLength":42)", R"("byteLength":56)");
  const auto scene = import_text("painted.glb", glb(json, triangle_bin() + shorts({0, 0, 0, 65535, 0, 0, 65535})));
  ASSERT_TRUE(scene.ok()) << scene.error().describe();
  ASSERT_EQ(scene->images.size(), 1U);
  const auto& texture = scene->materials.at(0).texture;
  ASSERT_TRUE(texture.has_value());
  EXPECT_EQ(texture->wrap_u, TextureWrap::kClamp);
  EXPECT_EQ(texture->wrap_v, TextureWrap::kMirror);
  EXPECT_EQ(texture->factor, glm::vec3(0.5F, 0.25F, 1));
  ASSERT_EQ(scene->texcoords.size(), 1U);
  const auto near = [](glm::vec2 a, glm::vec2 b) { return glm::distance(a, b) < 1e-4F; };
  const auto& uv = scene->texcoords[0].uv;
  EXPECT_TRUE(near(uv[0], {10, 20})) << uv[0].x << ' ' << uv[0].y;
  EXPECT_TRUE(near(uv[1], {10, 18})) << uv[1].x << ' '
                                     << uv[1].y;  // u = 1 turns towards lower v: anticlockwise as seen
  EXPECT_TRUE(near(uv[2], {11, 20})) << uv[2].x << ' ' << uv[2].y;
}

class GltfMeshopt : public Gltf {
 protected:
  // The triangle of triangle_bin(), packed; a fallback buffer that holds nothing stands behind the views.
  static std::string json(std::size_t vertex_bytes, std::size_t index_bytes, const std::string& filter = "NONE") {
    const auto number = [](std::size_t n) { return std::to_string(n); };
    const std::string packed = R"("extensions":{"EXT_meshopt_compression":{"buffer":0,)";
    return R"({"asset":{"version":"2.0"},"extensionsRequired":["EXT_meshopt_compression"],)"
           R"("scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],"meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1}]}],)"
           R"("accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"},{"bufferView":1,"componentType":5123,"count":3,"type":"SCALAR"}],)"
           R"("bufferViews":[{"buffer":1,"byteLength":36,"byteStride":12,)" +
           packed + R"("byteLength":)" + number(vertex_bytes) +
           R"(,"byteStride":12,"count":3,"mode":"ATTRIBUTES","filter":")" + filter +
           R"("}}},{"buffer":1,"byteOffset":36,"byteLength":6,)" + packed + R"("byteOffset":)" + number(vertex_bytes) +
           R"(,"byteLength":)" + number(index_bytes) + R"(,"byteStride":2,"count":3,"mode":"TRIANGLES"}}}],)" +
           R"("buffers":[{"byteLength":)" + number(vertex_bytes + index_bytes) + R"(},{"byteLength":42}]})";
  }
  void SetUp() override {
    Gltf::SetUp();
    const std::array<float, 9> positions = {0, 0, 0, 0, 0, 2, 2, 0, 0};
    vertices_.resize(meshopt_encodeVertexBufferBound(3, 12));
    meshopt_encodeVertexVersion(0);
    meshopt_encodeIndexVersion(1);
    vertices_.resize(meshopt_encodeVertexBuffer(reinterpret_cast<unsigned char*>(vertices_.data()), vertices_.size(),
                                                positions.data(), 3, 12));
    const std::array<unsigned, 3> triangle = {0, 1, 2};
    indices_.resize(meshopt_encodeIndexBufferBound(3, 3));
    indices_.resize(meshopt_encodeIndexBuffer(reinterpret_cast<unsigned char*>(indices_.data()), indices_.size(),
                                              triangle.data(), 3));
  }
  std::string file(const std::string& filter = "NONE") const {
    return glb(json(vertices_.size(), indices_.size(), filter), vertices_ + indices_);
  }
  std::string vertices_;
  std::string indices_;
};

TEST_F(GltfMeshopt, PackedViewsAreReadAsThePlainOnesAre) {
  const auto plain = import_text("plain.glb", glb(triangle_json(), triangle_bin()));
  const auto packed = import_text("packed.glb", file());
  ASSERT_TRUE(plain.ok());
  ASSERT_TRUE(packed.ok()) << packed.error().describe();
  EXPECT_EQ(packed->positions, plain->positions);
  EXPECT_EQ(packed->triangles, plain->triangles);
}

TEST_F(GltfMeshopt, DamageEndsInOneLineAndNeverInACrash) {
  const std::string whole = file();
  const std::size_t bin = whole.size() - vertices_.size() - indices_.size() - 4;
  for (std::size_t i = bin; i < whole.size(); ++i)
    for (const int flip : {1, 0x80, 0xFF}) {
      std::string bytes = whole;
      bytes[i] = static_cast<char>(bytes[i] ^ flip);
      const auto scene = import_text("damaged.glb", bytes);
      EXPECT_TRUE(scene.ok() || scene.error().describe().find('\n') == std::string::npos);
    }
  EXPECT_FALSE(import_text("filter.glb", file("MAGIC")).ok());
  EXPECT_FALSE(import_text("filter.glb", file("OCTAHEDRAL")).ok());  // not at twelve bytes
  std::string huge = json(vertices_.size(), indices_.size());
  huge.replace(huge.find("\"count\":3,\"mode\""), 16, "\"count\":4000000000,\"mode\"");
  const auto refused = import_text("huge.glb", glb(huge, vertices_ + indices_));
  ASSERT_FALSE(refused.ok());
  EXPECT_NE(refused.error().message.find("more than its bufferView"), std::string::npos);
}

TEST_F(Gltf, InstancesAreObjectsOfTheirOwn) {
  std::string json = triangle_json(
      R"("mesh":0,"name":"tree","translation":[100,0,0],"extensions":{"EXT_mesh_gpu_instancing":{"attributes":{"TRANSLATION":2,"SCALE":3}}})",
      R"("extensionsUsed":["EXT_mesh_gpu_instancing"],"extensionsRequired":["EXT_mesh_gpu_instancing"],)");
  const auto replace = [&](const std::string& what, const std::string& with) {
    json.replace(json.find(what), what.size(), with);
  };
  replace(
      R"("count":3,"type":"SCALAR"})",
      R"("count":3,"type":"SCALAR"},{"bufferView":2,"componentType":5126,"count":2,"type":"VEC3"},{"bufferView":2,"byteOffset":24,"componentType":5126,"count":2,"type":"VEC3"})");
  replace(R"("byteOffset":36,"byteLength":6})",
          R"("byteOffset":36,"byteLength":6},{"buffer":0,"byteOffset":44,"byteLength":48})");
  replace(R"("byteLength":42)", R"("byteLength":92)");
  const std::string bin = triangle_bin() + shorts({0}) + floats({1, 0, 0, 2, 5, 0, 1, 1, 1, 3, 3, 3});
  const auto scene = import_text("trees.glb", glb(json, bin));
  ASSERT_TRUE(scene.ok()) << scene.error().describe();
  expect_whole(*scene);
  ASSERT_EQ(scene->objects.size(), 2U);
  EXPECT_EQ(scene->objects[1].id, "tree_1");
  EXPECT_NEAR(area(*scene), 2 + 2 * 9, 1e-5);
  EXPECT_EQ(scene->positions[0], glm::dvec3(101, 0, 0));
  EXPECT_EQ(scene->positions[3], glm::dvec3(102, 0, 5));
  replace(R"("count":2,"type":"VEC3"},{"bufferView":2,"byteOffset":24)",
          R"("count":1,"type":"VEC3"},{"bufferView":2,"byteOffset":24)");
  EXPECT_FALSE(import_text("uneven.glb", glb(json, bin)).ok());
}

// Any number of times the same accessors, meshes and zeros: a file may grow, but not without a bound.
TEST_F(Gltf, WhatAFileGrowsToIsBoundedAsAWhole) {
  const auto refused = [&](const std::string& json, const std::string& bin, const std::string& words) {
    const auto scene = import_text("grows.glb", glb(json, bin));
    ASSERT_FALSE(scene.ok());
    EXPECT_NE(scene.error().message.find(words), std::string::npos) << scene.error().message;
    EXPECT_NE(scene.error().message.find("a glTF file of "), std::string::npos) << scene.error().message;
    EXPECT_EQ(scene.error().message.find('\n'), std::string::npos);
  };
  // One accessor of zeros, of ten primitives.
  std::string primitives;
  for (int i = 0; i < 10; ++i) primitives += std::string(i > 0 ? "," : "") + R"({"attributes":{"POSITION":0}})";
  const std::string zeros =
      R"({"asset":{"version":"2.0"},"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],"meshes":[{"primitives":[)" +
      primitives +
      R"(]}],"accessors":[{"componentType":5126,"count":300000,"type":"VEC3","sparse":{"count":1,)"
      R"("indices":{"bufferView":0,"componentType":5121},"values":{"bufferView":0}}}],)"
      R"("bufferViews":[{"buffer":0,"byteLength":64}],"buffers":[{"byteLength":64}]})";
  refused(zeros, std::string(64, '\0'), "primitive 3 POSITION, accessor 0 has 300000 more elements without bytes");

  // 900 nodes of one mesh of 5000 triangles.
  std::string nodes;
  std::string roots;
  for (int i = 0; i < 900; ++i) {
    nodes += std::string(i > 0 ? "," : "") + R"({"mesh":0})";
    roots += (i > 0 ? "," : "") + std::to_string(i);
  }
  std::string bin = floats({0, 0, 0, 0, 0, 2, 2, 0, 0});
  for (int i = 0; i < 5000; ++i) bin += std::string("\0\1\2", 3);
  const std::string shown = R"({"asset":{"version":"2.0"},"scenes":[{"nodes":[)" + roots + R"(]}],"nodes":[)" + nodes +
                            R"(],"meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1}]}],)"
                            R"("accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"},)"
                            R"({"bufferView":1,"componentType":5121,"count":15000,"type":"SCALAR"}],)"
                            R"("bufferViews":[{"buffer":0,"byteLength":36},{"buffer":0,"byteOffset":36,)"
                            R"("byteLength":15000}],"buffers":[{"byteLength":15036}]})";
  refused(shown, bin, "shows 5000 triangles 1 time, after ");
}

// 400 trees of 2000 triangles: more than the file has bytes.
TEST_F(Gltf, AnAvenueOfInstancedTreesIsRead) {
  constexpr int kTrees = 400;
  constexpr int kTriangles = 2000;
  std::string bin = floats({0, 0, 0, 0, 0, 2, 2, 0, 0});
  for (int i = 0; i < kTriangles; ++i) bin += std::string("\0\1\2", 3);
  for (int i = 0; i < kTrees; ++i) bin += floats({10.0F * static_cast<float>(i), 0, 0});
  const std::string indices = std::to_string(3 * kTriangles);
  const std::string places = std::to_string(12 * kTrees);
  const auto scene = import_text(
      "avenue.glb",
      glb(R"({"asset":{"version":"2.0"},"extensionsUsed":["EXT_mesh_gpu_instancing"],"scenes":[{"nodes":[0]}],)"
          R"("nodes":[{"mesh":0,"name":"tree","extensions":{"EXT_mesh_gpu_instancing":{"attributes":{"TRANSLATION":2}}}}],)"
          R"("meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1}]}],)"
          R"("accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"},)"
          R"({"bufferView":1,"componentType":5121,"count":)" +
              indices + R"(,"type":"SCALAR"},{"bufferView":2,"componentType":5126,"count":)" + std::to_string(kTrees) +
              R"(,"type":"VEC3"}],"bufferViews":[{"buffer":0,"byteLength":36},{"buffer":0,"byteOffset":36,"byteLength":)" +
              indices + R"(},{"buffer":0,"byteOffset":)" + std::to_string(36 + 3 * kTriangles) + R"(,"byteLength":)" +
              places + R"(}],"buffers":[{"byteLength":)" + std::to_string(bin.size()) + "}]}",
          bin));
  ASSERT_TRUE(scene.ok()) << scene.error().describe();
  EXPECT_EQ(scene->objects.size(), std::size_t{kTrees});
  EXPECT_EQ(scene->triangles.size(), std::size_t{kTrees} * kTriangles);
}

// As exporters write it: one list of positions, of which each primitive uses its part.
TEST_F(Gltf, PrimitivesThatShareTheirPositionsKeepTheirOwn) {
  std::string bin;
  for (int i = 0; i < 12; ++i) bin += floats({static_cast<float>(i), 0, static_cast<float>(i * i)});
  bin += shorts({2, 1, 0, 11, 9, 10});
  const auto scene = import_text(
      "shared.glb",
      glb(R"({"asset":{"version":"2.0"},"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],"meshes":[{"primitives":[)"
          R"({"attributes":{"POSITION":0},"indices":1},{"attributes":{"POSITION":0},"indices":2}]}],)"
          R"("accessors":[{"bufferView":0,"componentType":5126,"count":12,"type":"VEC3"},)"
          R"({"bufferView":1,"componentType":5123,"count":3,"type":"SCALAR"},)"
          R"({"bufferView":1,"byteOffset":6,"componentType":5123,"count":3,"type":"SCALAR"}],)"
          R"("bufferViews":[{"buffer":0,"byteLength":144},{"buffer":0,"byteOffset":144,"byteLength":12}],)"
          R"("buffers":[{"byteLength":156}]})",
          bin));
  ASSERT_TRUE(scene.ok()) << scene.error().describe();
  ASSERT_EQ(scene->triangles.size(), 2U);
  ASSERT_EQ(scene->positions.size(), 6U);
  EXPECT_EQ(scene->positions[0], glm::dvec3(2, -4, 0));
  EXPECT_EQ(scene->positions[2], glm::dvec3(0, 0, 0));
  EXPECT_EQ(scene->positions[3], glm::dvec3(11, -121, 0));
  EXPECT_EQ(scene->positions[5], glm::dvec3(10, -100, 0));
}

TEST_F(Gltf, WhatIsNotHandledIsNamed) {
  const auto scene = import_text(
      "ext.glb", glb(triangle_json(R"("mesh":0)", R"("extensionsRequired":["EXT_no_such_thing"],)"), triangle_bin()));
  ASSERT_FALSE(scene.ok());
  EXPECT_EQ(scene.error().code, ErrorCode::kUnsupported);
  EXPECT_NE(scene.error().message.find("EXT_no_such_thing"), std::string::npos);
}

TEST_F(Gltf, EveryKindOfLossIsCountedAndWrongTypesAreErrors) {
  const auto changed = [](const std::string& what, const std::string& with) {
    std::string json = triangle_json();
    json.replace(json.find(what), what.size(), with);
    return json;
  };
  const auto expect_noted = [&](const std::string& json, const char* words, std::uint64_t count) {
    const auto scene = import_text("loss.glb", glb(json, triangle_bin() + shorts({1, 2})));
    ASSERT_TRUE(scene.ok()) << scene.error().describe();
    EXPECT_EQ(noted(*scene, words), count) << words;
    EXPECT_EQ(scene->notes.size(), 1U) << words;
  };
  std::string loose = changed(R"("count":3,"type":"SCALAR")", R"("count":5,"type":"SCALAR")");
  loose.replace(loose.find(R"("byteLength":6})"), 15, R"("byteLength":10})");
  loose.replace(loose.find(R"("byteLength":42})"), 16, R"("byteLength":46})");
  expect_noted(loose, "behind the last whole triangle", 2);
  expect_noted(changed(R"("mesh":0)", R"("mesh":0,"skin":0)"), "skinned", 1);
  expect_noted(changed(R"([0.5,0.25,1,1])", R"([-1,0.25,1,1])"), "not within 0 and 1", 1);
  for (const auto& [what, with] : {std::pair{R"("mesh":0)", R"("mesh":"0")"},
                                   {R"("mesh":0)", R"("mesh":0.5)"},
                                   {R"([0.5,0.25,1,1])", R"(["a",0.25,1,1])"},
                                   {R"("material":0)", R"("material":[0])"},
                                   {R"("metallicFactor":0)", R"("metallicFactor":"0")"}}) {
    const auto scene = import_text("wrong.glb", glb(changed(what, with), triangle_bin()));
    ASSERT_FALSE(scene.ok()) << with;
    EXPECT_NE(scene.error().message.find(" that is no "), std::string::npos) << scene.error().describe();
  }
}

TEST_F(Gltf, WrongReferencesAreErrors) {
  const std::string good = triangle_json();
  ASSERT_TRUE(import_text("good.glb", glb(good, triangle_bin())).ok());
  const auto fails = [&](std::string_view from, std::string_view to) {
    std::string json = good;
    ASSERT_NE(json.find(from), std::string::npos) << from;
    json.replace(json.find(from), from.size(), to);
    EXPECT_FALSE(import_text("wrong.glb", glb(json, triangle_bin())).ok()) << to;
  };
  fails(R"("mesh":0)", R"("mesh":1)");
  fails(R"("mesh":0)", R"("mesh":0,"children":[0])");
  fails(R"("mesh":0)", R"("mesh":0,"children":[5])");
  fails(R"("mesh":0)", R"("mesh":0,"matrix":[1,2,3])");
  fails(R"("scene":0)", R"("scene":4)");
  fails(R"("indices":1)", R"("indices":7)");
  fails(R"("indices":1)", R"("indices":0)");
  fails(R"("POSITION":0)", R"("POSITION":1)");
  fails(R"("POSITION":0)", R"("POSITION":"x")");
  fails(R"("material":0)", R"("material":3)");
  fails(R"("material":0)", R"("material":0,"mode":9)");
  fails(R"("count":3,"type":"VEC3")", R"("count":4,"type":"VEC3")");
  fails(R"("count":3,"type":"VEC3")", R"("count":2,"type":"VEC3")");
  fails(R"("count":3,"type":"VEC3")", R"("count":18446744073709551615,"type":"VEC3")");
  fails(R"("byteOffset":36)", R"("byteOffset":40)");
  fails(R"("byteOffset":36)", R"("byteOffset":18446744073709551612)");
  fails(R"("buffer":0)", R"("buffer":1)");
  fails(R"([{"byteLength":42}])", R"([{"byteLength":420}])");
  fails(R"([{"byteLength":42}])", R"([{"byteLength":42,"uri":"gone.bin"}])");
  fails(R"([{"byteLength":42}])", R"([{"byteLength":"42"}])");
  fails(R"("version":"2.0")", R"("version":"1.0")");
}

// glTF 1.0 keeps its lists as objects by name, need not name its version, and has a binary form of its own.
TEST_F(Gltf, Version1IsNamedWithWhatConvertsIt) {
  const auto refuses = [&](const std::string& name, std::string_view bytes, const std::string& version,
                           const std::string& converter = "gltf-pipeline -i old.gltf -o new.glb") {
    const auto scene = import_text(name, bytes);
    ASSERT_FALSE(scene.ok()) << bytes;
    const std::string message = scene.error().describe();
    EXPECT_EQ(scene.error().code, ErrorCode::kUnsupported) << message;
    for (const std::string& part : {name, "glTF version " + version, converter})
      EXPECT_NE(message.find(part), std::string::npos) << "no '" << part << "' in: " << message;
  };
  const std::string lists = R"("accessors":{"a":{"bufferView":"b"}},"meshes":{"m":{"primitives":[]}})";
  refuses("text.gltf", R"({"asset":{"version":"1.0"},)" + lists + "}", "1.0");
  refuses("patch.gltf", R"({"asset":{"version":"1.0.1"},)" + lists + "}", "1.0.1");
  refuses("number.gltf", R"({"asset":{"version":1},)" + lists + "}", "1");
  refuses("fraction.gltf", R"({"asset":{"version":1.0},)" + lists + "}", "1.0");
  refuses("unnamed.gltf", R"({"asset":{"generator":"x"},)" + lists + "}", "1.0");
  refuses("bare.gltf", "{" + lists + "}", "1.0");
  std::string binary = "glTF";
  const std::string json = "{" + lists + "}";
  for (const std::size_t word : {std::size_t{1}, 20 + json.size(), json.size(), std::size_t{0}}) {
    const auto value = static_cast<std::uint32_t>(word);
    binary.append(reinterpret_cast<const char*>(&value), sizeof value);
  }
  refuses("binary.glb", binary + json, "1.0");
  for (const std::string version : {"3.0", "0.8"})
    refuses("other.gltf", R"({"asset":{"version":")" + version + R"("}})", version, "only 2.0 is read");
}

}  // namespace
}  // namespace zc::test
