// SPDX-License-Identifier: GPL-3.0-or-later
// CityGML 3.0: spaces and their boundaries, as OGC 20-010 and 21-006r2 spell them.
#include <cmath>
#include <map>

#include "tests/unit/baker/import/import_support.h"

namespace zc::test {
namespace {

class CityGml3 : public ImportTest {
 protected:
  static std::string model(const std::string& members) {
    return "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
           "<CityModel xmlns=\"http://www.opengis.net/citygml/3.0\" xmlns:gml=\"http://www.opengis.net/gml/3.2\" "
           "xmlns:con=\"http://www.opengis.net/citygml/construction/3.0\" "
           "xmlns:bldg=\"http://www.opengis.net/citygml/building/3.0\" "
           "xmlns:app=\"http://www.opengis.net/citygml/appearance/3.0\" "
           "xmlns:tran=\"http://www.opengis.net/citygml/transportation/3.0\" "
           "xmlns:veg=\"http://www.opengis.net/citygml/vegetation/3.0\" "
           "xmlns:dem=\"http://www.opengis.net/citygml/relief/3.0\" xmlns:xlink=\"http://www.w3.org/1999/xlink\" "
           "xmlns:xsi=\"http://www.w3.org/2001/XMLSchema-instance\" "
           "xsi:schemaLocation=\"http://www.opengis.net/citygml/building/3.0 "
           "http://schemas.opengis.net/citygml/building/3.0/building.xsd\">"
           "<gml:boundedBy><gml:Envelope srsName=\"EPSG:25832\" srsDimension=\"3\"/></gml:boundedBy>" +
           members + "</CityModel>";
  }
  static std::string member(const std::string& feature) {
    return "<cityObjectMember>" + feature + "</cityObjectMember>";
  }
  static std::string polygon(const std::string& id, const std::string& points) {
    return "<gml:Polygon gml:id=\"" + id + "\"><gml:exterior><gml:LinearRing gml:id=\"" + id + "_ring\"><gml:posList>" +
           points + "</gml:posList></gml:LinearRing></gml:exterior></gml:Polygon>";
  }
  // Across from (x, y, z) by dx along x, and by dy and dz: a rectangle.
  static std::string rectangle(const std::string& id, double x, double y, double z, double dx, double dy, double dz) {
    const auto point = [](double px, double py, double pz) {
      return std::to_string(px) + " " + std::to_string(py) + " " + std::to_string(pz) + " ";
    };
    return polygon(id, point(x, y, z) + point(x + dx, y, z) + point(x + dx, y + dy, z + dz) + point(x, y + dy, z + dz) +
                           point(x, y, z));
  }
  static std::string surfaces(int lod, const std::string& polygons) {
    const std::string property = "lod" + std::to_string(lod) + "MultiSurface";
    std::string text = "<" + property;
    text += "><gml:MultiSurface srsDimension=\"3\"><gml:surfaceMember>" + polygons;
    return text + "</gml:surfaceMember></gml:MultiSurface></" + property + ">";
  }
  static std::string solid(int lod, const std::string& members) {
    const std::string property = "lod" + std::to_string(lod) + "Solid";
    std::string text = "<" + property;
    text += "><gml:Solid><gml:exterior><gml:Shell>" + members;
    return text + "</gml:Shell></gml:exterior></gml:Solid></" + property + ">";
  }
  static std::string boundary(const std::string& surface, const std::string& content) {
    std::string text = "<boundary><" + surface;
    return text + ">" + content + "</" + surface + "></boundary>";
  }
  // Square metres by the materials' names, without the numbers of façade and roof colours.
  static std::map<std::string, double> areas(const Scene& scene) {
    std::map<std::string, double> sums;
    for (std::size_t t = 0; t < scene.triangles.size(); ++t) {
      const std::string& name = scene.materials[scene.triangle_material[t]].name;
      sums[name.substr(0, name.find(' '))] += glm::length(normal2(scene, t)) / 2;
    }
    for (auto& [name, sum] : sums) sum = std::round(sum * 1e6) / 1e6;
    return sums;
  }
  using Areas = std::map<std::string, double>;
};

TEST_F(CityGml3, BuildingsAreTheirBoundariesWithWindowsAndDoors) {
  const std::string wall =
      boundary("con:WallSurface",
               surfaces(3, rectangle("wall", 0, 0, 0, 4, 0, 3)) + "<con:fillingSurface><con:WindowSurface>" +
                   surfaces(3, rectangle("pane", 1, -0.1, 1, 1, 0, 1)) +
                   "</con:WindowSurface></con:fillingSurface><con:fillingSurface><con:DoorSurface>" +
                   surfaces(3, rectangle("leaf", 3, -0.1, 0, 0.5, 0, 2)) + "</con:DoorSurface></con:fillingSurface>");
  const std::string room = "<bldg:BuildingRoom>" +
                           solid(3, "<gml:surfaceMember>" + rectangle("r", 0, 1, 0, 9, 9, 0) + "</gml:surfaceMember>") +
                           "</bldg:BuildingRoom>";
  const auto column = [](const std::string& id, double y, const std::string& relation) {
    return "<bldg:buildingConstructiveElement><bldg:BuildingConstructiveElement><con:relationToConstruction>" +
           relation + "</con:relationToConstruction>" +
           boundary("con:WallSurface", surfaces(3, rectangle(id, 0, y, 0, 1, 0, 2))) +
           "</bldg:BuildingConstructiveElement></bldg:buildingConstructiveElement>";
  };
  const auto scene = import_text(
      "house.gml",
      model(member("<bldg:Building gml:id=\"house\">" + wall +
                   boundary("con:RoofSurface", surfaces(3, rectangle("roof", 0, 0, 3, 4, 5, 0))) +
                   boundary("con:GroundSurface", surfaces(3, rectangle("ground", 0, 5, 0, 4, -5, 0))) +
                   surfaces(0, rectangle("print", 0, 0, 0, 90, 90, 0)) +
                   solid(3, "<gml:surfaceMember xlink:href=\"#wall\"/><gml:surfaceMember xlink:href=\"#roof\"/>") +
                   "<bldg:buildingRoom>" + room + "</bldg:buildingRoom><bldg:buildingSubdivision><bldg:Storey>" +
                   solid(3, "<gml:surfaceMember>" + rectangle("storey", 0, 0, 0, 9, 9, 0) + "</gml:surfaceMember>") +
                   boundary("con:WallSurface", surfaces(3, rectangle("storey_wall", 0, 0, 0, 9, 0, 9))) +
                   column("in", 1, "inside") + column("out", -1, "outside") +
                   "</bldg:Storey></bldg:buildingSubdivision></bldg:Building>")));
  ASSERT_TRUE(scene.ok()) << scene.error().describe();
  expect_whole(*scene);
  ASSERT_EQ(scene->objects.size(), 1U);
  EXPECT_EQ(areas(*scene),
            (Areas{{"WallSurface", 12 + 2}, {"Window", 1}, {"Door", 1}, {"RoofSurface", 20}, {"GroundSurface", 20}}));
  EXPECT_EQ(noted(*scene, "rooms"), 2U);
}

TEST_F(CityGml3, TrafficSpacesAreTheirGroundAndNotTheAirAboveIt) {
  const std::string air = solid(2, "<gml:surfaceMember>" + rectangle("air", 0, 0, 4, 9, 9, 0) + "</gml:surfaceMember>");
  const std::string lane = "<tran:trafficSpace><tran:TrafficSpace gml:id=\"lane\">" +
                           boundary("tran:TrafficArea", surfaces(2, rectangle("area", 0, 0, 0, 10, 4, 0))) +
                           boundary("ClosureSurface", surfaces(2, rectangle("side", 0, 0, 0, 10, 0, 4))) + air +
                           "<tran:granularity>lane</tran:granularity><tran:clearanceSpace><tran:ClearanceSpace>" + air +
                           "</tran:ClearanceSpace></tran:clearanceSpace></tran:TrafficSpace></tran:trafficSpace>";
  const std::string kerb = "<tran:auxiliaryTrafficSpace><tran:AuxiliaryTrafficSpace>" +
                           surfaces(2, rectangle("kerb", 0, 4, 0, 10, 1, 0)) +
                           "</tran:AuxiliaryTrafficSpace></tran:auxiliaryTrafficSpace>";
  const std::string crossing = "<tran:intersection><tran:Intersection><tran:trafficSpace><tran:TrafficSpace>" +
                               boundary("tran:TrafficArea", surfaces(1, rectangle("cross", 10, 0, 0, 3, 3, 0))) +
                               "</tran:TrafficSpace></tran:trafficSpace></tran:Intersection></tran:intersection>";
  const auto scene = import_text(
      "road.gml",
      model(member("<tran:Road gml:id=\"road\">" + surfaces(1, rectangle("outline", 0, 0, 0, 50, 50, 0)) +
                   "<tran:section><tran:Section>" + lane + kerb + "<tran:marking><tran:Marking>" +
                   surfaces(3, rectangle("line", 0, 2, 0.01, 10, 0.2, 0)) +
                   "</tran:Marking></tran:marking></tran:Section></tran:section>" + crossing + "</tran:Road>")));
  ASSERT_TRUE(scene.ok()) << scene.error().describe();
  ASSERT_EQ(scene->objects.size(), 1U);
  EXPECT_EQ(scene->objects[0].kind, ObjectKind::kGround);
  EXPECT_EQ(areas(*scene),
            (Areas{{"TrafficArea", 40 + 9}, {"AuxiliaryTrafficArea", 10}, {"TransportationMarking", 2}}));
  EXPECT_EQ(noted(*scene, "spaces that are empty"), 3U);
  EXPECT_EQ(noted(*scene, "footprints and areas"), 1U);
}

TEST_F(CityGml3, PlantsAndReliefAreRead) {
  const auto tree = [](const std::string& geometry, const std::string& point) {
    return member(
        "<veg:SolitaryVegetationObject><lod2ImplicitRepresentation><ImplicitGeometry><transformationMatrix>"
        "2 0 0 0 0 2 0 0 0 0 2 0 0 0 0 1</transformationMatrix>" +
        geometry + "<referencePoint><gml:Point><gml:pos>" + point +
        "</gml:pos></gml:Point></referencePoint></ImplicitGeometry></lod2ImplicitRepresentation>"
        "</veg:SolitaryVegetationObject>");
  };
  const auto scene = import_text(
      "park.gml",
      model(tree("<relativeGeometry><gml:MultiSurface gml:id=\"crown\"><gml:surfaceMember>" +
                     rectangle("leaf", 0, 0, 0, 1, 0, 1) + "</gml:surfaceMember></gml:MultiSurface></relativeGeometry>",
                 "10 20 30") +
            tree("<relativeGeometry xlink:href=\"#crown\"/>", "50 60 70") +
            member("<veg:PlantCover>" +
                   boundary("GenericThematicSurface", surfaces(1, rectangle("grass", 0, 0, 0, 3, 3, 0))) +
                   "</veg:PlantCover>") +
            member("<dem:ReliefFeature><dem:lod>1</dem:lod><dem:reliefComponent><dem:TINRelief><dem:lod>1</dem:lod>"
                   "<dem:tin><gml:TriangulatedSurface><gml:patches><gml:Triangle><gml:exterior><gml:LinearRing>"
                   "<gml:posList>0 0 0 8 0 0 0 8 0 0 0 0</gml:posList></gml:LinearRing></gml:exterior></gml:Triangle>"
                   "</gml:patches></gml:TriangulatedSurface></dem:tin></dem:TINRelief></dem:reliefComponent>"
                   "<dem:reliefComponent><dem:TINRelief><dem:tin><gml:Tin><gml:controlPoint><gml:posList>0 0 0 1 1 1"
                   "</gml:posList></gml:controlPoint></gml:Tin></dem:tin></dem:TINRelief></dem:reliefComponent>"
                   "</dem:ReliefFeature>")));
  ASSERT_TRUE(scene.ok()) << scene.error().describe();
  EXPECT_EQ(scene->objects.size(), 4U);
  EXPECT_EQ(areas(*scene), (Areas{{"SolitaryVegetationObject", 8}, {"PlantCover", 9}, {"TINRelief", 32}}));
  EXPECT_NE(std::find(scene->positions.begin(), scene->positions.end(), glm::dvec3(52, 60, 72)),
            scene->positions.end());
  EXPECT_EQ(noted(*scene, "not joined to triangles"), 1U);
}

TEST_F(CityGml3, AppearancesAssociateTexturesWithSurfaces) {
  write("brick.png", std::string("\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\0\0\x02\0\0\0\x01\x08\x02\0\0\0\x7b\x40\xe8\xdd"
                                 "\0\0\0\x0fIDATx\x9c\x63\x60\x60\x60\xf8\xff\xff\x3f\0\x06\x01\x02\xfe\x02\xb2\x39\xae"
                                 "\0\0\0\0IEND\xae\x42\x60\x82",
                                 72));
  const std::string appearance =
      "<appearanceMember><app:Appearance><app:theme>rgb</app:theme><app:surfaceData><app:ParameterizedTexture>"
      "<app:imageURI>brick.png</app:imageURI><app:wrapMode>wrap</app:wrapMode><app:textureParameterization>"
      "<app:TextureAssociation><app:target>#both</app:target><app:textureParameterization><app:TexCoordList>"
      "<app:textureCoordinates>0 0 2 0 2 1 0 1 0 0</app:textureCoordinates>"
      "<app:textureCoordinates>0 0 4 0 4 1 0 1 0 0</app:textureCoordinates>"
      "<app:ring>#a_ring</app:ring><app:ring>#b_ring</app:ring></app:TexCoordList></app:textureParameterization>"
      "</app:TextureAssociation></app:textureParameterization></app:ParameterizedTexture></app:surfaceData>"
      "<app:surfaceData><app:X3DMaterial><app:diffuseColor>1 0 0</app:diffuseColor><app:target>#c</app:target>"
      "</app:X3DMaterial></app:surfaceData></app:Appearance></appearanceMember>";
  const std::string walls = "<lod2MultiSurface><gml:MultiSurface gml:id=\"both\"><gml:surfaceMember>" +
                            rectangle("a", 0, 0, 0, 4, 0, 3) + "</gml:surfaceMember><gml:surfaceMember>" +
                            rectangle("b", 0, 5, 0, 4, 0, 3) +
                            "</gml:surfaceMember></gml:MultiSurface></lod2MultiSurface>";
  const auto scene = import_text(
      "shed.gml", model(appearance + member("<bldg:Building>" + boundary("con:WallSurface", walls) +
                                            boundary("con:RoofSurface", surfaces(2, rectangle("c", 0, 0, 3, 4, 5, 0))) +
                                            "</bldg:Building>")));
  ASSERT_TRUE(scene.ok()) << scene.error().describe();
  ASSERT_EQ(scene->texcoords.size(), 4U);
  for (const auto& [triangle, uv] : scene->texcoords)
    for (std::size_t k = 0; k < 3; ++k) {
      const glm::dvec3 p = scene->positions[scene->triangles[triangle][k]];
      EXPECT_EQ(uv[k], glm::vec2(p.x > 2 ? (p.y > 2 ? 4 : 2) : 0, p.z > 1 ? 0 : 1));
    }
  ASSERT_EQ(scene->materials.size(), 2U);
  EXPECT_TRUE(scene->materials[0].texture.has_value());
  EXPECT_EQ(scene->materials[1].base_color, glm::vec3(1, 0, 0));
}

TEST_F(CityGml3, EveryTruncationAndChangedByteEndsWithoutACrash) {
  const std::string whole = model(
      "<appearanceMember><app:Appearance><app:surfaceData><app:ParameterizedTexture><app:imageURI>a.png</app:imageURI>"
      "<app:textureParameterization><app:TextureAssociation><app:target>#a</app:target><app:textureParameterization>"
      "<app:TexCoordList><app:textureCoordinates>0 0 1 1</app:textureCoordinates><app:ring>#a_ring</app:ring>"
      "</app:TexCoordList></app:textureParameterization></app:TextureAssociation></app:textureParameterization>"
      "</app:ParameterizedTexture></app:surfaceData></app:Appearance></appearanceMember>" +
      member("<tran:Road>" + surfaces(1, rectangle("o", 0, 0, 0, 5, 5, 0)) +
             "<tran:section><tran:Section><tran:trafficSpace><tran:TrafficSpace>" +
             boundary("tran:TrafficArea", surfaces(2, rectangle("a", 0, 0, 0, 10, 4, 0))) +
             solid(2, "<gml:surfaceMember xlink:href=\"#a\"/>") +
             "</tran:TrafficSpace></tran:trafficSpace></tran:Section></tran:section></tran:Road>") +
      member("<veg:PlantCover>" + solid(1, "<gml:surfaceMember xlink:href=\"#s\"/>") +
             boundary("GenericThematicSurface", surfaces(1, rectangle("s", 0, 0, 0, 3, 3, 0))) + "</veg:PlantCover>") +
      member("<veg:SolitaryVegetationObject><lod1ImplicitRepresentation><ImplicitGeometry><relativeGeometry "
             "xlink:href=\"#s\"/><referencePoint><gml:Point><gml:pos>1 2 3</gml:pos></gml:Point></referencePoint>"
             "</ImplicitGeometry></lod1ImplicitRepresentation></veg:SolitaryVegetationObject>"));
  const auto scene = import_text("whole.gml", whole);
  ASSERT_TRUE(scene.ok()) << scene.error().describe();
  EXPECT_EQ(scene->objects.size(), 3U);
  for (std::size_t i = 0; i < whole.size(); i += 13) EXPECT_FALSE(import_text("cut.gml", whole.substr(0, i)).ok()) << i;
  for (std::size_t i = 0; i < whole.size(); i += 5) {
    std::string bytes = whole;
    bytes[i] = static_cast<char>(bytes[i] ^ 0x11);
    const auto changed = import_text("changed.gml", bytes);
    if (changed.ok()) expect_whole(*changed);
  }
}

}  // namespace
}  // namespace zc::test
