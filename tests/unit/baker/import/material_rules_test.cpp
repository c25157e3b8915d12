// SPDX-License-Identifier: GPL-3.0-or-later
// Rules of materials: patterns, what is refused, and what a city becomes under them.
#include "baker/import/shared/material_rules.h"

#include <algorithm>

#include "tests/unit/baker/import/import_support.h"

namespace zc {
namespace {

TEST(MaterialRules, PatternsFitWholeTexts) {
  for (const auto& [pattern, text] : std::vector<std::pair<const char*, const char*>>{{"", ""},
                                                                                      {"*", ""},
                                                                                      {"*", "any"},
                                                                                      {"Wall*", "WallSurface"},
                                                                                      {"*Surface", "WallSurface"},
                                                                                      {"W?ll*e", "WallSurface"},
                                                                                      {"*a*a*", "xaxax"},
                                                                                      {"a**b", "ab"}})
    EXPECT_TRUE(fits_pattern(pattern, text)) << pattern << " " << text;
  for (const auto& [pattern, text] : std::vector<std::pair<const char*, const char*>>{
           {"", "a"}, {"?", ""}, {"Wall", "WallSurface"}, {"*Roof", "WallSurface"}, {"*a*a*", "xaxx"}})
    EXPECT_FALSE(fits_pattern(pattern, text)) << pattern << " " << text;
}

TEST(MaterialRules, AreRefusedByTheirPlace) {
  const auto refusal = [](const char* json) {
    const auto rules = MaterialRules::parse(json, "m.json");
    return rules.ok() ? "read" : rules.error().describe();
  };
  EXPECT_EQ(refusal(R"({"materials":[{"surface":"*","roughness":0.1}]})"), "read");
  for (const auto& [json, words] : std::vector<std::pair<const char*, const char*>>{
           {"{", "m.json"},
           {"[]", "no list"},
           {R"({"materials":[{"roughness":0.1},7]})", "materials[1] is no object"},
           {R"({"materials":[{"surface":"*"}]})", "materials[0] changes nothing"},
           {R"({"materials":[{"surfaces":"*","roughness":0}]})", "unknown member 'surfaces'"},
           {R"({"materials":[{"surface":1,"roughness":0}]})", "surface is no text"},
           {R"({"materials":[{"roughness":1.5}]})", "roughness is no number from 0 to 1"},
           {R"({"materials":[{"base_color":[1,2,3]}]})", "base_color is no list of three numbers"}})
    EXPECT_NE(refusal(json).find(words), std::string::npos) << refusal(json);
}

class RuledCity : public test::ImportTest {
 protected:
  // A tower and a shed, each one wall, and a road.
  Result<Scene> city(const char* rules, bool wet = false) const {
    const std::string json =
        R"({"type":"CityJSON","version":"1.1","transform":{"scale":[1,1,1],"translate":[0,0,0]},"CityObjects":{)"
        R"("tower-1":{"type":"Building","geometry":[{"type":"MultiSurface","lod":"2","boundaries":[[[0,1,2]]],)"
        R"("semantics":{"surfaces":[{"type":"WallSurface"}],"values":[0]}}]},)"
        R"("shed":{"type":"Building","geometry":[{"type":"MultiSurface","lod":"2","boundaries":[[[0,1,3]]],)"
        R"("semantics":{"surfaces":[{"type":"WallSurface"}],"values":[0]}}]},)"
        R"("road":{"type":"Road","geometry":[{"type":"MultiSurface","lod":"2","boundaries":[[[0,1,4]]],)"
        R"("semantics":{"surfaces":[{"type":"AuxiliaryTrafficArea"}],"values":[0]}}]}},)"
        R"("vertices":[[0,0,0],[9,0,0],[9,0,9],[0,0,9],[9,9,0]]})";
    const auto path = write("city.json", json);
    ImportOptions options;
    if (rules != nullptr) {
      auto parsed = MaterialRules::parse(rules, "m.json");
      EXPECT_TRUE(parsed.ok()) << parsed.error().describe();
      options.materials = *std::move(parsed);
    }
    if (wet) options.materials.wet_ground();
    return import_inputs(std::span(&path, 1), options);
  }
  static const Material& of(const Scene& scene, const std::string& object) {
    const auto found = std::ranges::find_if(scene.objects, [&](const SceneObject& o) { return o.id == object; });
    return scene.materials[scene.triangle_material[found->first_triangle]];
  }
};

TEST_F(RuledCity, TheFirstRuleThatFitsCounts) {
  const auto scene = city(R"({"materials":[
    {"surface":"WallSurface","object":"Building","name":"tower*","base_color":[0.1,0.2,0.3],"roughness":0.03},
    {"surface":"Wall*","metallic":0.5},
    {"name":"shed","roughness":0.01}]})");
  ASSERT_TRUE(scene.ok()) << scene.error().describe();
  EXPECT_EQ(of(*scene, "tower-1").base_color, glm::vec3(0.1F, 0.2F, 0.3F));
  EXPECT_EQ(of(*scene, "tower-1").roughness, 0.03F);
  EXPECT_EQ(of(*scene, "tower-1").metallic, 0);
  EXPECT_EQ(of(*scene, "shed").metallic, 0.5F);
  EXPECT_EQ(of(*scene, "shed").roughness, 0.85F) << "a later rule";
  EXPECT_EQ(of(*scene, "road").roughness, of(*city(nullptr), "road").roughness);
}

TEST_F(RuledCity, RainMakesRoadsSmoothAndDarkAndNothingElse) {
  const auto dry = city(nullptr);
  const auto wet = city(nullptr, true);
  ASSERT_TRUE(dry.ok() && wet.ok());
  EXPECT_LT(of(*wet, "road").roughness, 0.1F);
  EXPECT_LT(of(*wet, "road").base_color.x, of(*dry, "road").base_color.x);
  EXPECT_EQ(of(*wet, "shed").roughness, of(*dry, "shed").roughness);
}

TEST_F(RuledCity, AGroundPlaneLiesUnderEverything) {
  const auto path =
      write("city.json", R"({"type":"CityJSON","version":"1.1","transform":{"scale":[1,1,1],"translate":[0,0,5]},)"
                         R"("CityObjects":{"a":{"type":"Building","geometry":[{"type":"MultiSurface","lod":"1",)"
                         R"("boundaries":[[[0,1,2]]]}]}},"vertices":[[0,0,0],[9,0,0],[9,0,9]]})");
  ImportOptions options{.ground_plane = true};
  const auto scene = import_inputs(std::span(&path, 1), options);
  ASSERT_TRUE(scene.ok());
  ASSERT_EQ(scene->objects.back().id, "ground plane");
  EXPECT_EQ(scene->positions.back().z, 5);
  EXPECT_GT(test::normal2(*scene, scene->triangles.size() - 1).z, 0);
  options.ground_plane_z_m = -2;
  EXPECT_EQ(import_inputs(std::span(&path, 1), options)->positions.back().z, -2);
}

}  // namespace
}  // namespace zc
