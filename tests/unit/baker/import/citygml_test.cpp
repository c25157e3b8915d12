// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/unit/baker/import/import_support.h"

namespace zc::test {
namespace {

class CityGml : public ImportTest {
 protected:
  static std::string model(const std::string& members, const std::string& crs = "EPSG:25832") {
    return "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
           "<core:CityModel xmlns:core=\"http://www.opengis.net/citygml/2.0\" xmlns:gml=\"http://www.opengis.net/gml\" "
           "xmlns:bldg=\"http://www.opengis.net/citygml/building/2.0\" "
           "xmlns:app=\"http://www.opengis.net/citygml/appearance/2.0\" "
           "xmlns:frn=\"http://www.opengis.net/citygml/cityfurniture/2.0\" "
           "xmlns:dem=\"http://www.opengis.net/citygml/relief/2.0\" xmlns:xlink=\"http://www.w3.org/1999/xlink\">"
           "<gml:boundedBy><gml:Envelope srsName=\"" +
           crs + "\"/></gml:boundedBy>" + members + "</core:CityModel>";
  }
  static std::string member(const std::string& feature) {
    return "<core:cityObjectMember>" + feature + "</core:cityObjectMember>";
  }
  static std::string polygon(const std::string& id, const std::string& points, const std::string& interior = "") {
    std::string text = "<gml:Polygon gml:id=\"" + id + "\"><gml:exterior><gml:LinearRing gml:id=\"" + id +
                       "_ring\"><gml:posList>" + points + "</gml:posList></gml:LinearRing></gml:exterior>";
    if (!interior.empty())
      text +=
          "<gml:interior><gml:LinearRing><gml:posList>" + interior + "</gml:posList></gml:LinearRing></gml:interior>";
    return text + "</gml:Polygon>";
  }
  static std::string surfaces(const std::string& property, const std::string& polygons) {
    std::string text = "<" + property + "><gml:MultiSurface>";
    return text + "<gml:surfaceMember>" + polygons + "</gml:surfaceMember></gml:MultiSurface></" + property + ">";
  }
  // A wall of 4 m by 3 m with a window in a hole, both at LoD3; and a block of LoD1 that must not be seen.
  static std::string house() {
    return member(
        "<bldg:Building gml:id=\"house\">"
        "<bldg:lod3Solid><gml:Solid><gml:exterior><gml:CompositeSurface><gml:surfaceMember xlink:href=\"#wall\"/>"
        "</gml:CompositeSurface></gml:exterior></gml:Solid></bldg:lod3Solid>"
        "<bldg:boundedBy><bldg:WallSurface>" +
        surfaces("bldg:lod3MultiSurface",
                 polygon("wall", "0 0 0 4 0 0 4 0 3 0 0 3 0 0 0", "1 0 1 1 0 2 2 0 2 2 0 1 1 0 1")) +
        "<bldg:opening><bldg:Window>" +
        surfaces("bldg:lod3MultiSurface", polygon("glass", "1 0 1 2 0 1 2 0 2 1 0 2 1 0 1")) +
        "</bldg:Window></bldg:opening></bldg:WallSurface></bldg:boundedBy>" +
        surfaces("bldg:lod1MultiSurface", polygon("block", "0 0 0 9 0 0 9 9 0 0 9 0 0 0 0")) +
        "<bldg:interiorRoom><bldg:Room>" +
        surfaces("bldg:lod4MultiSurface", polygon("room", "0 0 0 9 0 0 9 9 0 0 9 0 0 0 0")) +
        "</bldg:Room></bldg:interiorRoom></bldg:Building>");
  }
};

TEST_F(CityGml, FeaturesAreShownAtTheirHighestLevelWithTheirSemantics) {
  const auto scene = import_text("house.gml", model(house()));
  ASSERT_TRUE(scene.ok()) << scene.error().describe();
  expect_whole(*scene);
  EXPECT_EQ(scene->crs, "EPSG:25832");
  ASSERT_EQ(scene->objects.size(), 1U);
  EXPECT_EQ(scene->objects[0].id, "house");
  EXPECT_NEAR(area(*scene), 12, 1e-9);  // the wall without its hole, and the pane in it
  double glass = 0;
  for (std::size_t t = 0; t < scene->triangles.size(); ++t) {
    EXPECT_LT(normal2(*scene, t).y, 0);  // all face -y
    if (scene->materials[scene->triangle_material[t]].name == "Window") glass += glm::length(normal2(*scene, t)) / 2;
  }
  EXPECT_NEAR(glass, 1, 1e-9);
}

TEST_F(CityGml, AppearancesPaintPolygonsRingByRing) {
  write("brick.png", std::string("\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\0\0\x02\0\0\0\x01\x08\x02\0\0\0\x7b\x40\xe8\xdd"
                                 "\0\0\0\x0fIDATx\x9c\x63\x60\x60\x60\xf8\xff\xff\x3f\0\x06\x01\x02\xfe\x02\xb2\x39\xae"
                                 "\0\0\0\0IEND\xae\x42\x60\x82",
                                 72));
  const std::string appearance =
      "<app:appearanceMember><app:Appearance><app:theme>summer</app:theme>"
      "<app:surfaceDataMember><app:ParameterizedTexture><app:imageURI>brick.png</app:imageURI><app:wrapMode>wrap"
      "</app:wrapMode><app:target uri=\"#a\"><app:TexCoordList><app:textureCoordinates ring=\"#a_ring\">"
      "0 0 2 0 2 1 0 1 0 0</app:textureCoordinates></app:TexCoordList></app:target></app:ParameterizedTexture>"
      "</app:surfaceDataMember><app:surfaceDataMember><app:X3DMaterial><app:diffuseColor>1 0 0</app:diffuseColor>"
      "<app:target>#b</app:target></app:X3DMaterial></app:surfaceDataMember></app:Appearance></app:appearanceMember>"
      "<app:appearanceMember><app:Appearance><app:theme>winter</app:theme></app:Appearance></app:appearanceMember>";
  const std::string shed = member("<bldg:Building gml:id=\"shed\"><bldg:boundedBy><bldg:WallSurface>" +
                                  surfaces("bldg:lod2MultiSurface", polygon("a", "0 0 0 4 0 0 4 0 3 0 0 3 0 0 0") +
                                                                        polygon("b", "0 5 0 4 5 0 4 5 3 0 5 3 0 5 0")) +
                                  "</bldg:WallSurface></bldg:boundedBy></bldg:Building>");
  const auto scene = import_text("shed.gml", model(appearance + shed));
  ASSERT_TRUE(scene.ok()) << scene.error().describe();
  EXPECT_EQ(noted(*scene, "further themes"), 1U);
  ASSERT_EQ(scene->texcoords.size(), 2U);
  for (const auto& [triangle, uv] : scene->texcoords)
    for (std::size_t k = 0; k < 3; ++k) {
      const glm::dvec3 p = scene->positions[scene->triangles[triangle][k]];
      EXPECT_EQ(uv[k], glm::vec2(p.x > 2 ? 2 : 0, p.z > 1 ? 0 : 1));  // v runs downwards from here on
    }
  ASSERT_EQ(scene->materials.size(), 2U);
  EXPECT_TRUE(scene->materials[0].texture.has_value());
  EXPECT_EQ(scene->materials[1].base_color, glm::vec3(1, 0, 0));
}

TEST_F(CityGml, ImplicitGeometryIsPlacedAndReusedByReference) {
  const auto lamp = [](const std::string& id, const std::string& geometry, const std::string& point) {
    return member("<frn:CityFurniture gml:id=\"" + id +
                  "\"><frn:lod2ImplicitRepresentation><core:ImplicitGeometry>"
                  "<core:transformationMatrix>2 0 0 0 0 2 0 0 0 0 2 0 0 0 0 1</core:transformationMatrix>" +
                  geometry + "<core:referencePoint><gml:Point><gml:pos>" + point +
                  "</gml:pos></gml:Point></core:referencePoint></core:ImplicitGeometry>"
                  "</frn:lod2ImplicitRepresentation></frn:CityFurniture>");
  };
  const auto scene = import_text(
      "lamps.gml", model(lamp("first",
                              "<core:relativeGMLGeometry><gml:MultiSurface gml:id=\"shape\"><gml:surfaceMember>" +
                                  polygon("p", "0 0 0 1 0 0 0 1 0 0 0 0") +
                                  "</gml:surfaceMember></gml:MultiSurface></core:relativeGMLGeometry>",
                              "10 20 30") +
                         lamp("second", "<core:relativeGMLGeometry xlink:href=\"#shape\"/>", "50 60 70")));
  ASSERT_TRUE(scene.ok()) << scene.error().describe();
  ASSERT_EQ(scene->objects.size(), 2U);
  EXPECT_NEAR(area(*scene), 4, 1e-9);
  const auto has = [&](const glm::dvec3& p) {
    return std::find(scene->positions.begin(), scene->positions.end(), p) != scene->positions.end();
  };
  EXPECT_TRUE(has({12, 20, 30}));
  EXPECT_TRUE(has({50, 62, 70}));
}

TEST_F(CityGml, ReliefAndOtherSpellingsOfCoordinatesAreRead) {
  const std::string relief = member(
      "<dem:ReliefFeature gml:id=\"hill\"><dem:lod>1</dem:lod><dem:reliefComponent><dem:TINRelief><dem:lod>1</dem:lod>"
      "<dem:tin><gml:TriangulatedSurface><gml:trianglePatches><gml:Triangle><gml:exterior><gml:LinearRing>"
      "<gml:pos>0 0 0</gml:pos><gml:pos>8 0 1</gml:pos><gml:pos>0 8 1</gml:pos><gml:pos>0 0 0</gml:pos>"
      "</gml:LinearRing></gml:exterior></gml:Triangle><gml:Triangle><gml:exterior><gml:LinearRing>"
      "<gml:coordinates>8,0,1 8,8,2 0,8,1 8,0,1</gml:coordinates></gml:LinearRing></gml:exterior></gml:Triangle>"
      "</gml:trianglePatches></gml:TriangulatedSurface></dem:tin></dem:TINRelief></dem:reliefComponent></"
      "dem:ReliefFeature>");
  const auto scene = import_text("hill.gml", model(relief));
  ASSERT_TRUE(scene.ok()) << scene.error().describe();
  EXPECT_EQ(scene->triangles.size(), 2U);
  EXPECT_EQ(scene->objects[0].kind, ObjectKind::kGround);
}

TEST_F(CityGml, GeographicCoordinatesGetALocalFrame) {
  const auto scene = import_text(
      "tokyo.gml",
      model(member("<bldg:Building gml:id=\"b\">" +
                   surfaces(
                       "bldg:lod1MultiSurface",
                       polygon("p",
                               "35.68 139.76 10 35.68 139.761 10 35.681 139.761 10 35.681 139.76 10 35.68 139.76 10")) +
                   "</bldg:Building>"),
            "http://www.opengis.net/def/crs/EPSG/0/6697"));
  ASSERT_TRUE(scene.ok()) << scene.error().describe();
  EXPECT_EQ(noted(*scene, "in degrees"), 1U);
  EXPECT_NEAR(area(*scene), 90.51 * 110.95, 25);  // metres of a thousandth of a degree at that latitude
  for (std::size_t t = 0; t < scene->triangles.size(); ++t) EXPECT_GT(normal2(*scene, t).z, 0);
}

TEST_F(CityGml, WhatIsWrongIsNamedWithItsPlace) {
  const auto refused = [&](const std::string& text, const std::string& words) {
    const auto scene = import_text("wrong.gml", text);
    ASSERT_FALSE(scene.ok()) << words;
    EXPECT_NE(scene.error().describe().find(words), std::string::npos) << scene.error().describe();
    EXPECT_EQ(scene.error().describe().find('\n'), std::string::npos);
  };
  refused("<a><b></a>", "invalid XML");
  refused("<city/>", "root is city, not a CityModel: expected a CityModel of CityGML 1.0, 2.0 or 3.0");
  for (const char* other : {"http://www.opengis.net/citygml/4.0", "http://www.citygml.org/citygml/1/0/0"})
    refused("<CityModel xmlns=\"" + std::string(other) + "\"/>",
            "'" + std::string(other) + "': expected a CityModel of");
  refused(model(""), "no triangles");
  std::string text = model(house());
  text.replace(text.find("4 0 3"), 5, "4 O 3");
  refused(text, "'O 3");
  text = model(house());
  text.replace(text.find("4 0 3"), 5, "4 0");
  refused(text, "in threes");
  for (const char* dimension : {"2", "0"}) {
    text = model(house());
    text.replace(text.find("posList>"), 8, std::string("posList srsDimension=\"") + dimension + "\">");
    refused(text, std::string("srsDimension is '") + dimension);
  }
  std::string deep;
  for (int i = 0; i < 100'000; ++i) deep += "<x>";
  for (int i = 0; i < 100'000; ++i) deep += "</x>";
  refused(model(member("<bldg:Building>" + deep + "</bldg:Building>")), "nest deeper");
}

TEST_F(CityGml, TheRootsNamespaceDecidesWhateverElseTheTextSays) {
  const std::string building = "<c:cityObjectMember><Building>" +
                               surfaces("b:lod1MultiSurface", polygon("p", "0 0 0 4 0 0 4 0 3 0 0 3 0 0 0")) +
                               "</Building></c:cityObjectMember>";
  const auto document = [&](const std::string& namespaces) {
    return "<?xml version=\"1.0\"?><!-- CityGML http://www.opengis.net/citygml/4.0 -->\n<c:CityModel " + namespaces +
           " xmlns:b=\"urn:b\" xmlns:gml=\"urn:gml\" xmlns:xsi=\"http://www.w3.org/2001/XMLSchema-instance\" "
           "xsi:schemaLocation=\"http://www.opengis.net/citygml/building/4.0 "
           "http://schemas.opengis.net/citygml/building/4.0/building.xsd\">" +
           building + "</c:CityModel>";
  };
  for (const char* core : {"http://www.opengis.net/citygml/1.0", "http://www.opengis.net/citygml/2.0",
                           "http://www.opengis.net/citygml/3.0", "http://www.opengis.net/citygml/profiles/base/2.0"}) {
    const auto scene = import_text(
        "house.gml", document("xmlns=\"http://www.opengis.net/citygml/5.0\" xmlns:c=\"" + std::string(core) + "\""));
    ASSERT_TRUE(scene.ok()) << scene.error().describe();
    EXPECT_NEAR(area(*scene), 12, 1e-9);
  }
  EXPECT_FALSE(import_text("house.gml", document("xmlns=\"http://www.opengis.net/citygml/2.0\" "
                                                 "xmlns:c=\"http://www.opengis.net/citygml/5.0\""))
                   .ok());
}

TEST_F(CityGml, ReferencesWithinAnObjectAreFollowedOnce) {
  // The solid has the polygons, the wall names them, and names what names itself; the roof's is of another level.
  const std::string refer = "<gml:surfaceMember xlink:href=\"#";
  const auto scene = import_text(
      "house.gml",
      model(member("<bldg:Building gml:id=\"house\"><bldg:lod2Solid><gml:Solid><gml:exterior><gml:CompositeSurface>"
                   "<gml:surfaceMember>" +
                   polygon("wall", "0 0 0 4 0 0 4 0 3 0 0 3 0 0 0") + "</gml:surfaceMember>" + refer + "other\"/>" +
                   refer +
                   "cap\"/></gml:CompositeSurface></gml:exterior></gml:Solid></bldg:lod2Solid>"
                   "<bldg:boundedBy><bldg:GroundSurface><bldg:lod2MultiSurface><gml:MultiSurface gml:id=\"loop\">" +
                   refer + "loop\"/>" + refer + "wall\"/>" + refer + "wall\"/>" +
                   "</gml:MultiSurface></bldg:lod2MultiSurface></bldg:GroundSurface></bldg:boundedBy>" +
                   surfaces("bldg:lod1MultiSurface", polygon("cap", "0 0 3 4 0 3 4 2 3 0 2 3 0 0 3")) +
                   "</bldg:Building>") +
            member("<bldg:Building gml:id=\"next\">" +
                   surfaces("bldg:lod2MultiSurface", polygon("other", "9 0 0 10 0 0 10 0 1 9 0 1 9 0 0")) +
                   "</bldg:Building>")));
  ASSERT_TRUE(scene.ok()) << scene.error().describe();
  ASSERT_EQ(scene->objects.size(), 2U);
  EXPECT_NEAR(area(*scene), 12 + 8 + 1, 1e-9);
  EXPECT_EQ(scene->materials[scene->triangle_material[0]].name, "GroundSurface");
  EXPECT_EQ(noted(*scene, "outside of their object"), 1U);
}

TEST_F(CityGml, ImplicitGeometriesThatNestEndAtOnce) {
  const auto placed = [](const std::string& shape) {
    return "<core:ImplicitGeometry><core:relativeGMLGeometry xlink:href=\"#" + shape +
           "\"/><core:referencePoint><gml:Point><gml:pos>0 0 0</gml:pos></gml:Point></core:referencePoint>"
           "</core:ImplicitGeometry>";
  };
  std::string text = member("<bldg:Building><bldg:lod2ImplicitRepresentation>" + placed("g0") +
                            "</bldg:lod2ImplicitRepresentation></bldg:Building>");
  for (int i = 0; i < 40; ++i) {
    const std::string next = "g" + std::to_string(i + 1);
    text += "<x><gml:MultiSurface gml:id=\"g" + std::to_string(i) + "\">" + placed(next) + placed(next) +
            "</gml:MultiSurface></x>";
  }
  text += "<x><gml:MultiSurface gml:id=\"g40\">" + polygon("p", "0 0 0 1 0 0 0 1 0 0 0 0") + "</gml:MultiSurface></x>";
  const auto scene = import_text("laughs.gml", model(text));
  ASSERT_FALSE(scene.ok());
  EXPECT_NE(scene.error().message.find("implicit geometries within implicit geometries, left out: 2"),
            std::string::npos)
      << scene.error().describe();
}

TEST_F(CityGml, PlacementsAreBoundedByTheFile) {
  std::string ring;
  for (int i = 0; i < 100'000; ++i) ring += std::to_string(i) + " 0 0 ";
  std::string text;
  for (int i = 0; i < 200; ++i)
    text +=
        "<bldg:lod2ImplicitRepresentation><core:ImplicitGeometry><core:relativeGMLGeometry xlink:href=\"#shape\"/>"
        "<core:referencePoint><gml:Point><gml:pos>0 0 0</gml:pos></gml:Point></core:referencePoint>"
        "</core:ImplicitGeometry></bldg:lod2ImplicitRepresentation>";
  const auto scene = import_text(
      "many.gml", model(member("<bldg:Building>" + text + "</bldg:Building>") +
                        "<x><gml:MultiSurface gml:id=\"shape\">" + polygon("p", ring) + "</gml:MultiSurface></x>"));
  ASSERT_FALSE(scene.ok());
  EXPECT_EQ(scene.error().code, ErrorCode::kBudget);
  EXPECT_NE(scene.error().message.find("split it into several files"), std::string::npos) << scene.error().message;
}

TEST_F(CityGml, ReferenceSystemsAreReadAsTheyAreSpelled) {
  const std::string tokyo = "35.68 139.76 10 35.68 139.761 10 35.681 139.761 10 35.681 139.76 10 35.68 139.76 10";
  const std::string turned = "139.76 35.68 10 139.761 35.68 10 139.761 35.681 10 139.76 35.681 10 139.76 35.68 10";
  const auto building = [](const std::string& points) {
    return member("<bldg:Building>" + surfaces("bldg:lod1MultiSurface", polygon("p", points)) + "</bldg:Building>");
  };
  for (const auto& [crs, points] :
       {std::pair<std::string, std::string>{"urn:ogc:def:crs,crs:EPSG:6.12:4326,crs:EPSG:6.12:5783", tokyo},
        {"http://www.opengis.net/def/crs-compound?1=http://www.opengis.net/def/crs/EPSG/0/6697&amp;2=http://x/1",
         tokyo},
        {"urn:ogc:def:crs:EPSG::4979", tokyo},
        {"EPSG:4326+5773", tokyo},
        {"urn:ogc:def:crs:OGC:1.3:CRS84", turned}}) {
    const auto scene = import_text("tokyo.gml", model(building(points), crs));
    ASSERT_TRUE(scene.ok()) << scene.error().describe();
    EXPECT_NEAR(area(*scene), 90.51 * 110.95, 25) << crs;
    for (std::size_t t = 0; t < scene->triangles.size(); ++t) EXPECT_GT(normal2(*scene, t).z, 0) << crs;
  }
  const std::string metres = building("458875 5438355 112 458885 5438355 112 458885 5438360 112 458875 5438355 112");
  for (const std::string crs :
       {"urn:ogc:def:crs,crs:EPSG::25832,crs:EPSG::5783", "urn:adv:crs:ETRS89_UTM32*DE_DHHN2016_NH", "EPSG:25832"}) {
    const auto scene = import_text("city.gml", model(metres, crs));
    ASSERT_TRUE(scene.ok()) << scene.error().describe();
    EXPECT_EQ(scene->crs, crs);
    EXPECT_NEAR(area(*scene), 25, 1e-6);
  }
  // Where the model names none, what is in it may.
  std::string inner = model(metres);
  inner.replace(inner.find("<gml:boundedBy>"), 15, "<gml:unknown>");
  inner.replace(inner.find("</gml:boundedBy>"), 16, "</gml:unknown>");
  inner.replace(inner.find("EPSG:25832"), 10, "EPSG:25833");
  const auto scene = import_text("inner.gml", inner);
  ASSERT_TRUE(scene.ok()) << scene.error().describe();
  EXPECT_EQ(scene->crs, "EPSG:25833");
}

TEST_F(CityGml, EveryTruncationAndChangedByteEndsWithoutACrash) {
  const std::string whole = model(house());
  for (std::size_t i = 0; i < whole.size(); i += 7) EXPECT_FALSE(import_text("cut.gml", whole.substr(0, i)).ok()) << i;
  for (std::size_t i = 0; i < whole.size(); i += 3) {
    std::string bytes = whole;
    bytes[i] = static_cast<char>(bytes[i] ^ 0x11);
    const auto scene = import_text("changed.gml", bytes);
    if (scene.ok()) expect_whole(*scene);
  }
}

}  // namespace
}  // namespace zc::test
