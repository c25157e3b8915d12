// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/import/other_formats.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "baker/import/citygml/citygml_import.h"
#include "baker/import/shared/json_text.h"
#include "base/text.h"

namespace zc {
namespace {

using namespace std::string_view_literals;

constexpr const char* kAsModel = "export it as glTF, OBJ or PLY";
constexpr const char* kAsCity = "export it as CityGML, CityJSON or glTF";
constexpr const char* kPoints = "make a mesh of its points and bake that";
constexpr const char* kFlat = "make a 3D model of it first, as CityJSON, CityGML or glTF";
constexpr const char* kPicture = "name the model that it belongs to";
constexpr const char* kUnpack = "unpack it and bake what is in it";
constexpr const char* kNotThis = "name the file of the model";

struct Mark {
  std::size_t at;
  std::string_view bytes;
  OtherFormat format;
};

// The first that fits counts.
constexpr std::array kMarks = {
    Mark{0, "ISO-10303-21"sv, {"a STEP file", "export its surfaces as glTF, OBJ or PLY"}},
    Mark{0, "Kaydara FBX Binary"sv, {"an FBX model", kAsModel}},
    Mark{0, "; FBX "sv, {"an FBX model", kAsModel}},
    Mark{0, "solid "sv, {"an STL model", kAsModel}},
    Mark{0, "PXR-USDC"sv, {"a USD model", kAsModel}},
    Mark{0, "#usda "sv, {"a USD model", kAsModel}},
    Mark{0, "BLENDER"sv, {"a Blender file", kAsModel}},
    Mark{0, "\xFF\xFE\xFF\x0ES\0k\0e\0t\0c\0h\0U\0p\0"sv, {"a SketchUp model", kAsModel}},
    Mark{0, "#VRML "sv, {"a VRML model", kAsModel}},
    Mark{0, "OFF\n"sv, {"an OFF model", kAsModel}},
    Mark{0, "DRACO"sv, {"a Draco mesh by itself", "put it into a glTF file (KHR_draco_mesh_compression)"}},
    Mark{0, "newmtl "sv, {"a material library (MTL)", "name the OBJ file that uses it"}},
    Mark{0, "AutoCAD Binary DXF"sv, {"a DXF drawing", "export its surfaces as glTF, OBJ or PLY"}},
    Mark{0, "AC10"sv, {"a DWG drawing", "export its surfaces as glTF, OBJ or PLY"}},
    Mark{0, "LASF"sv, {"a point cloud (LAS or LAZ)", kPoints}},
    Mark{0, "ASTM-E57"sv, {"a point cloud (E57)", kPoints}},
    Mark{0, "# .PCD"sv, {"a point cloud (PCD)", kPoints}},
    Mark{0, "\0\0\x27\x0A\0\0\0\0"sv, {"a shapefile", kFlat}},
    Mark{68, "GPKG"sv, {"a GeoPackage", kFlat}},
    Mark{0, "SQLite format 3\0"sv, {"an SQLite database", "export the city in it as CityGML or CityJSON"}},
    Mark{4, "\x0A\x09OSMHeader"sv, {"OpenStreetMap data (PBF)", kFlat}},
    Mark{0, "ZCWORLD\n"sv, {"a world that was baked before", "bake the models that it was made of"}},
    Mark{0, "%PDF-"sv, {"a PDF document", kNotThis}},
    Mark{0, "\xFF\xD8\xFF"sv, {"a JPEG picture", kPicture}},
    Mark{0, "\x89PNG"sv, {"a PNG picture", kPicture}},
    Mark{8, "WEBP"sv, {"a WebP picture", kPicture}},
    Mark{0, "GIF8"sv, {"a GIF picture", kPicture}},
    Mark{0, "II*\0"sv, {"a TIFF picture", kPicture}},
    Mark{0, "MM\0*"sv, {"a TIFF picture", kPicture}},
    Mark{0, "\xABKTX "sv, {"a KTX texture", kPicture}},
    Mark{4, "ftyp"sv, {"a video", kNotThis}},
    Mark{0,
         "\x7F"
         "ELF"sv,
         {"a program", kNotThis}},
    Mark{0, "7z\xBC\xAF\x27\x1C"sv, {"a 7z archive", kUnpack}},
    Mark{0, "Rar!\x1A\x07"sv, {"a RAR archive", kUnpack}},
    Mark{257, "ustar"sv, {"a tar archive", kUnpack}},
    Mark{0, "BZh"sv, {"a bzip2 file", kUnpack}},
    Mark{0,
         "\xFD"
         "7zXZ\0"sv,
         {"an xz file", kUnpack}},
    Mark{0, "\x28\xB5\x2F\xFD"sv, {"a Zstandard file", kUnpack}},
};

struct Root {
  std::string_view name;
  OtherFormat format;
};
constexpr std::array kRoots = {
    Root{"COLLADA", {"a COLLADA model", kAsModel}},
    Root{"X3D", {"an X3D model", kAsModel}},
    Root{"kml", {"a KML document", kFlat}},
    Root{"osm", {"OpenStreetMap data", kFlat}},
    Root{"LandXML", {"a LandXML document", kAsModel}},
    Root{"ifcXML", {"an IFC model", kAsCity}},
    Root{"FeatureCollection", {"GML that is no CityGML", "export it as CityGML"}},
    Root{"IndoorFeatures", {"IndoorGML", "export the building as CityGML"}},
    Root{"Dictionary", {"a GML code list", kNotThis}},
    Root{"html", {"a web page", "the download may have failed: get the model again"}},
    Root{"svg", {"an SVG picture", kPicture}},
};

struct Member {
  const char* key;
  OtherFormat format;
};
constexpr std::array kMembers = {
    Member{"features", {"GeoJSON", kFlat}},    Member{"geometry", {"GeoJSON", kFlat}},
    Member{"coordinates", {"GeoJSON", kFlat}}, Member{"geometries", {"GeoJSON", kFlat}},
    Member{"arcs", {"TopoJSON", kFlat}},
};

// Which begins with the group code 0 and the word SECTION, or with comments of the group code 999.
bool is_dxf(std::string_view text) {
  const std::size_t code = text.find_first_not_of(" \t");
  if (code == std::string_view::npos) return false;
  text.remove_prefix(code);
  if (text.starts_with("999\r\n") || text.starts_with("999\n")) return true;
  if (!take(text, "0")) return false;
  const std::size_t word = text.find_first_not_of(" \t\r\n");
  return word != std::string_view::npos && word > 0 && text.substr(word).starts_with("SECTION");
}

// Its first chunk has the length of the whole file.
bool is_3ds(std::string_view bytes) {
  if (bytes.size() < 6 || !bytes.starts_with("MM")) return false;
  std::uint32_t length = 0;
  for (std::size_t i = 0; i < 4; ++i) length |= std::uint32_t{static_cast<unsigned char>(bytes[2 + i])} << (8 * i);
  return length == bytes.size();
}

// A header of 80 bytes, a count, 50 bytes for each triangle.
bool is_binary_stl(std::string_view bytes) {
  constexpr std::size_t kHeader = 84;
  if (bytes.size() < kHeader) return false;
  std::uint64_t count = 0;
  for (std::size_t i = 0; i < 4; ++i) count |= std::uint64_t{static_cast<unsigned char>(bytes[80 + i])} << (8 * i);
  return count > 0 && bytes.size() == kHeader + 50 * count;
}

}  // namespace

std::optional<OtherFormat> other_format(std::string_view bytes) {
  constexpr std::size_t kHeaderBytes = 4096;
  if (bytes.starts_with("ISO-10303-21") && bytes.substr(0, kHeaderBytes).find("'IFC") != std::string_view::npos)
    return OtherFormat{"an IFC model", kAsCity};
  if (is_3ds(bytes)) return OtherFormat{"a 3DS model", kAsModel};
  for (const Mark& mark : kMarks)
    if (bytes.size() >= mark.at && bytes.substr(mark.at).starts_with(mark.bytes)) return mark.format;
  if (is_dxf(bytes)) return OtherFormat{"a DXF drawing", "export its surfaces as glTF, OBJ or PLY"};
  if (is_binary_stl(bytes)) return OtherFormat{"an STL model", kAsModel};
  const std::size_t start = bytes.find_first_not_of(" \t\r\n\xEF\xBB\xBF");
  if (start == std::string_view::npos) return std::nullopt;
  if (bytes[start] == '<') {
    const std::string root = root_of_xml(bytes);
    for (const Root& known : kRoots)
      if (root == known.name) return known.format;
  }
  if (bytes[start] == '{' && !has_top_level_key(bytes, "CityObjects"))
    for (const Member& member : kMembers)
      if (has_top_level_key(bytes, member.key)) return member.format;
  return std::nullopt;
}

std::optional<OtherFormat> other_archive(std::span<const std::string> names) {
  const auto has = [&](const auto& fits) { return std::any_of(names.begin(), names.end(), fits); };
  const auto ends = [](std::string_view end) {
    return [end](const std::string& name) { return lower(name).ends_with(end); };
  };
  if (has(ends(".usdc")) || has(ends(".usda"))) return OtherFormat{"a USDZ model", kAsModel};
  if (has(ends(".kml"))) return OtherFormat{"a KMZ document", kFlat};
  if (has(ends("3dscenelayer.json")) || has(ends("3dscenelayer.json.gz")))
    return OtherFormat{"an I3S scene layer (SLPK)", "export it as 3D Tiles"};
  if (has(ends(".shp"))) return OtherFormat{"an archive of shapefiles", kFlat};
  if (has(ends(".fbx"))) return OtherFormat{"an archive of FBX models", kAsModel};
  if (has(ends(".dae"))) return OtherFormat{"an archive of COLLADA models", kAsModel};
  if (has(ends(".ifc"))) return OtherFormat{"an archive of IFC models", kAsCity};
  return std::nullopt;
}

}  // namespace zc
