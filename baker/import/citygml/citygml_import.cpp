// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/import/citygml/citygml_import.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/mat4x4.hpp>
#include <glm/matrix.hpp>
#include <memory>
#include <unordered_map>

#include "baker/import/citygml/citygml_appearance.h"
#include "baker/import/shared/json_text.h"
#include "baker/import/shared/polygon.h"
#include "baker/import/shared/surface_material.h"
#include "baker/import/shared/uri.h"

namespace zc {
namespace {

constexpr int kMaxDepth = 200;
constexpr int kMaxLod = 3;

// Geographic systems by their EPSG codes: latitude, longitude and, in all but the two-dimensional ones, height.
constexpr std::array<std::string_view, 8> kGeographic = {"4326", "4258", "4937", "4979",
                                                         "6667", "6668", "6697", "7423"};

bool is_geographic(std::string_view crs) {
  const std::size_t last = crs.find_last_not_of("0123456789");
  const std::string_view code = last == std::string_view::npos ? crs : crs.substr(last + 1);
  return std::find(kGeographic.begin(), kGeographic.end(), code) != kGeographic.end();
}

// 0 to 4 for "lod3Solid"; nothing for other names. Relief has it elsewhere, and only one.
std::optional<int> lod_of(std::string_view name) {
  if (name == "tin") return kMaxLod;
  if (!name.starts_with("lod") || name.size() < 5 || name[3] < '0' || name[3] > '4') return std::nullopt;
  return name[3] - '0';
}

// What is under such an element is not the shape of a feature.
bool is_left_out(std::string_view name) {
  return name == "interiorRoom" || name == "roomInstallation" || name == "interiorFurniture" ||
         name == "interiorBuildingInstallation" || name == "Room" || name == "appearance" || name == "boundedBySolid" ||
         name.ends_with("TerrainIntersection") || name.ends_with("MultiCurve");
}

// Features that stand within another one and choose their own level of detail.
bool is_part(std::string_view name) {
  return name == "BuildingPart" || name == "BuildingInstallation" || name == "BridgePart" || name == "TunnelPart" ||
         name == "BridgeInstallation" || name == "TunnelInstallation" || name == "BridgeConstructionElement" ||
         name == "TINRelief";
}

// As surface_of_object() and kind_of_city_object() know them.
std::string object_type(std::string_view name) {
  constexpr std::array<std::pair<std::string_view, std::string_view>, 8> kNames = {
      {{"Square", "TransportSquare"},
       {"Track", "Road"},
       {"TransportationComplex", "Road"},
       {"ReliefFeature", "TINRelief"},
       {"WaterSurface", "WaterBody"},
       {"BridgeConstructionElement", "BridgeConstructiveElement"},
       {"GenericCityObject", "GenericCityObject"},
       {"TINRelief", "TINRelief"}}};
  for (const auto& [ours, theirs] : kNames)
    if (ours == name) return std::string(theirs);
  return std::string(name);
}

struct FoundPolygon {
  pugi::xml_node node;
  std::optional<Surface> surface;     // of the nearest semantic element
  std::vector<std::string_view> ids;  // of the polygon and what it is part of, from the inside
  bool flipped = false;
  const glm::dmat4* placement = nullptr;
};

class CityGmlImport {
 public:
  CityGmlImport(const std::string& path, std::optional<EarthFrame>& earth, TextureImages& images, SceneBuilder& builder)
      : path_(path), folder_(folder_of(path)), earth_(earth), images_(images), builder_(builder) {}

  Status run(const pugi::xml_node& model) {
    ZC_TRY(read_crs(model));
    std::uint64_t other_themes = 0;
    ZC_ASSIGN(appearance_, GmlAppearance::read(model, path_, other_themes));
    if (other_themes > 0) builder_.note("appearances of further themes, left out", other_themes);
    for (const pugi::xml_node& member : model.children()) {
      const std::string_view name = local_name(member);
      if (name != "cityObjectMember" && name != "featureMember" && name != "featureMembers") continue;
      for (const pugi::xml_node& feature : member.children())
        if (feature.type() == pugi::node_element) ZC_TRY(add_object(feature, model));
    }
    return {};
  }

 private:
  struct Gathered {
    std::array<std::vector<FoundPolygon>, 5> by_lod;
    std::vector<std::pair<pugi::xml_node, int>> parts;  // with their depths
  };

  Status read_crs(const pugi::xml_node& model) {
    std::string_view crs = gml_attribute(gml_child(gml_child(model, "boundedBy"), "Envelope"), "srsName");
    if (crs.empty()) crs = gml_attribute(model, "srsName");
    geographic_ = is_geographic(crs);
    if (!geographic_) return builder_.set_crs(std::string(crs), path_);
    return {};
  }

  Status add_object(const pugi::xml_node& feature, const pugi::xml_node& model) {
    ObjectMesh mesh;
    mesh.id = gml_attribute(feature, "id");
    if (mesh.id.empty()) mesh.id = "at byte " + std::to_string(feature.offset_debug());
    mesh.kind = kind_of_city_object(object_type(local_name(feature)));
    builder_.enter_object(mesh.id);
    const std::string palette_key = mesh.id;
    std::vector<std::pair<pugi::xml_node, int>> features = {{feature, 0}};
    for (std::size_t i = 0; i < features.size(); ++i) {
      Gathered gathered;
      placements_.clear();
      const auto [own, depth] = features[i];
      ZC_TRY(gather(own, depth, {}, std::nullopt, gathered, model));
      features.insert(features.end(), gathered.parts.begin(), gathered.parts.end());
      int lod = kMaxLod;
      while (lod >= 0 && gathered.by_lod[static_cast<std::size_t>(lod)].empty()) --lod;
      if (lod < 0 && !gathered.by_lod[4].empty()) {
        lod = 4;
        builder_.note("features with LoD4 alone, shown without their interiors");
      }
      if (lod < 0) continue;
      const std::string type = object_type(local_name(own));
      for (const FoundPolygon& polygon : gathered.by_lod[static_cast<std::size_t>(lod)])
        ZC_TRY(add_polygon(polygon, type, palette_key, mesh));
    }
    return builder_.add(mesh);
  }

  struct Inherited {
    std::optional<Surface> surface;
    std::vector<std::string_view> ids;
    bool flipped = false;
    const glm::dmat4* placement = nullptr;
  };

  // The polygons of a feature by level of detail; parts within are only named.
  Status gather(const pugi::xml_node& node, int depth, Inherited above, std::optional<int> lod, Gathered& out,
                const pugi::xml_node& model) {
    if (depth > kMaxDepth) return gml_error(node, "elements nest deeper than " + std::to_string(kMaxDepth), path_);
    const std::string_view id = gml_attribute(node, "id");
    if (!id.empty()) above.ids.insert(above.ids.begin(), id);
    for (const pugi::xml_node& child : node.children()) {
      if (child.type() != pugi::node_element) continue;
      const std::string_view name = local_name(child);
      if (is_left_out(name)) continue;
      if (is_part(name)) {
        out.parts.emplace_back(child, depth + 1);
        continue;
      }
      if (name == "Polygon" || name == "PolygonPatch" || name == "Triangle" || name == "Rectangle") {
        if (!lod) continue;  // an envelope, say
        FoundPolygon found{child, above.surface, above.ids, above.flipped, above.placement};
        if (const std::string_view own = gml_attribute(child, "id"); !own.empty())
          found.ids.insert(found.ids.begin(), own);
        out.by_lod[static_cast<std::size_t>(*lod)].push_back(std::move(found));
        continue;
      }
      Inherited below = above;
      if (const auto surface = surface_of_semantics(name)) below.surface = surface;
      if (name == "OrientableSurface" && gml_attribute(child, "orientation") == "-") below.flipped = !below.flipped;
      const std::optional<int> own = lod_of(name);
      if (name == "ImplicitGeometry") {
        ZC_TRY(gather_implicit(child, depth + 1, below, own ? own : lod, out, model));
        continue;
      }
      ZC_TRY(gather(child, depth + 1, below, own ? own : lod, out, model));
    }
    return {};
  }

  // A geometry in a frame of its own: a matrix by rows, then a point of the model's frame.
  Status gather_implicit(const pugi::xml_node& node, int depth, Inherited above, std::optional<int> lod, Gathered& out,
                         const pugi::xml_node& model) {
    glm::dmat4 placement(1);
    if (const pugi::xml_node matrix = gml_child(node, "transformationMatrix")) {
      ZC_ASSIGN(const std::vector<double> numbers, gml_numbers(matrix, path_));
      if (numbers.size() != 16) return gml_error(matrix, "transformationMatrix has not 16 numbers", path_);
      for (std::size_t i = 0; i < 16; ++i) placement[static_cast<int>(i % 4)][static_cast<int>(i / 4)] = numbers[i];
    }
    const pugi::xml_node point = gml_child(gml_child(node, "referencePoint"), "Point");
    ZC_ASSIGN(const std::vector<glm::dvec3> at, points_of(point));
    if (at.size() != 1) return gml_error(node, "an implicit geometry has no reference point", path_);
    ZC_ASSIGN(const glm::dvec3 world, to_world(at[0], node));
    placement[3] += glm::dvec4(world, 0);
    pugi::xml_node geometry = gml_child(node, "relativeGMLGeometry");
    if (!geometry) {
      builder_.note("implicit geometries in files of their own, left out");
      return {};
    }
    if (const std::string_view href = gml_attribute(geometry, "href"); href.starts_with('#')) {
      geometry = by_id(href.substr(1), model);
      if (!geometry) {
        builder_.note("references to geometry that is not in the file, left out");
        return {};
      }
    }
    placements_.push_back(std::make_unique<glm::dmat4>(placement));
    above.placement = placements_.back().get();
    return gather(geometry, depth, above, lod, out, model);
  }

  // Of every element with an id, found on first use. The first of two counts.
  pugi::xml_node by_id(std::string_view id, const pugi::xml_node& model) {
    if (ids_.empty()) {
      for (pugi::xml_node node = model; node;) {
        if (const std::string_view own = gml_attribute(node, "id"); !own.empty()) ids_.try_emplace(own, node);
        if (node.first_child()) {
          node = node.first_child();
          continue;
        }
        while (node && node != model && !node.next_sibling()) node = node.parent();
        node = node == model ? pugi::xml_node() : node.next_sibling();
      }
    }
    const auto found = ids_.find(id);
    return found != ids_.end() ? found->second : pugi::xml_node();
  }

  // As they are written: posList, pos one by one, or the older coordinates.
  Result<std::vector<glm::dvec3>> points_of(const pugi::xml_node& ring) {
    std::vector<glm::dvec3> points;
    for (const pugi::xml_node& child : ring.children()) {
      const std::string_view name = local_name(child);
      pugi::xml_node holder = child;
      if (name == "pointProperty")
        holder = gml_child(gml_child(child, "Point"), "pos");
      else if (name != "posList" && name != "pos" && name != "coordinates")
        continue;
      // Of the list itself, or of the geometry that it is part of.
      for (pugi::xml_node at = holder; at && local_name(at) != "CityModel"; at = at.parent()) {
        const std::string_view dimension = gml_attribute(at, "srsDimension");
        if (dimension.empty()) continue;
        if (dimension != "3")
          return gml_error(at, "srsDimension is '" + one_line(dimension) + "', only three numbers a point are read",
                           path_);
        break;
      }
      ZC_ASSIGN(const std::vector<double> numbers, gml_numbers(holder, path_));
      if (numbers.size() % 3 != 0) return gml_error(child, "coordinates that do not come in threes", path_);
      for (std::size_t i = 0; i < numbers.size(); i += 3)
        points.emplace_back(numbers[i], numbers[i + 1], numbers[i + 2]);
    }
    return points;
  }

  Result<glm::dvec3> to_world(const glm::dvec3& p, const pugi::xml_node& node) {
    if (!geographic_) return p;
    if (!(std::abs(p.x) <= 90 && std::abs(p.y) <= 360 && std::abs(p.z) < 1e5))
      return gml_error(node, "a place that is not on the earth", path_);
    const Geodetic place{p.y, p.x, p.z};
    if (!earth_) {
      earth_.emplace(place);
      builder_.note("geographic coordinates, moved to a local frame");
    }
    if (!crs_set_) ZC_TRY(builder_.set_crs(earth_->crs(), path_));
    crs_set_ = true;
    return glm::dvec3(earth_->from_geocentric() * glm::dvec4(geocentric_of(place), 1));
  }

  Status add_ring(const pugi::xml_node& holder, const FoundPolygon& found) {
    const pugi::xml_node ring = gml_child(holder, "LinearRing");
    if (!ring) return gml_error(holder, "a boundary without a LinearRing", path_);
    ZC_ASSIGN(std::vector<glm::dvec3> points, points_of(ring));
    for (glm::dvec3& p : points) {
      if (found.placement != nullptr) {
        p = glm::dvec3(*found.placement * glm::dvec4(p, 1));
      } else {
        ZC_ASSIGN(p, to_world(p, ring));
      }
    }
    const std::vector<glm::vec2>* uv = appearance_.texcoords(gml_attribute(ring, "id"));
    if (uv == nullptr || uv->size() < points.size()) {
      textured_ = false;
    } else {
      for (std::size_t i = 0; i < points.size(); ++i) texcoords_.emplace_back((*uv)[i].x, 1 - (*uv)[i].y);
    }
    for (const glm::dvec3& p : points) polygon_.add_point(p);
    polygon_.end_ring();
    return {};
  }

  Status add_polygon(const FoundPolygon& found, const std::string& type, const std::string& palette_key,
                     ObjectMesh& mesh) {
    polygon_.clear();
    texcoords_.clear();
    textured_ = true;
    const pugi::xml_node exterior = gml_child(found.node, "exterior");
    if (!exterior) return gml_error(found.node, "a polygon without an exterior", path_);
    ZC_TRY(add_ring(exterior, found));
    for (const pugi::xml_node& interior : found.node.children())
      if (local_name(interior) == "interior") ZC_TRY(add_ring(interior, found));

    const bool mirrored = found.placement != nullptr && glm::determinant(glm::dmat3(*found.placement)) < 0;
    const bool flipped = found.flipped != mirrored;
    const glm::dvec3 normal = newell_normal(polygon_) * (flipped ? -1.0 : 1.0);
    const double length = glm::length(normal);
    const Surface surface =
        found.surface ? *found.surface : surface_of_object(type, length > 0 ? normal.z / length : 0);
    cut_.clear();
    const auto [outcome, filled_holes] = triangulate_polygon(polygon_, cut_);
    if (const char* loss = loss_of(outcome)) builder_.note(loss);
    if (filled_holes > 0) builder_.note(kFilledHoles, filled_holes);
    if (cut_.empty()) return {};
    if (textured_)
      for (const auto& [from, to, part] : polygon_.crossings)
        texcoords_.push_back(glm::mix(texcoords_[from], texcoords_[to], static_cast<float>(part)));
    const Paint paint = paint_of(found);
    const std::uint16_t material = builder_.material(surface_material(surface, type, palette_key, paint));
    const std::size_t base = mesh.positions.size();
    if (base + polygon_.points.size() > 0xFFFF'FFFFU)
      return gml_error(found.node, "an object of more than 2^32 corners", path_);
    mesh.positions.insert(mesh.positions.end(), polygon_.points.begin(), polygon_.points.end());
    for (const auto& [a, b, c] : cut_) {
      const std::array corners = flipped ? std::array{a, c, b} : std::array{a, b, c};
      if (paint.texture && textured_)
        mesh.texcoords.push_back({static_cast<std::uint32_t>(mesh.triangles.size()),
                                  {texcoords_[corners[0]], texcoords_[corners[1]], texcoords_[corners[2]]}});
      const auto at = [base](std::uint32_t corner) { return static_cast<std::uint32_t>(base + corner); };
      mesh.triangles.push_back({at(corners[0]), at(corners[1]), at(corners[2])});
      mesh.materials.push_back(material);
    }
    return {};
  }

  Paint paint_of(const FoundPolygon& found) {
    Paint paint;
    for (const std::string_view id : found.ids)
      if (const GmlMaterial* material = appearance_.material(id); material != nullptr) {
        paint = {material->color, {}, material->transparent, material->name};
        break;
      }
    for (const std::string_view id : found.ids) {
      const GmlTexture* texture = appearance_.texture(id);
      if (texture == nullptr) continue;
      if (const auto loaded = images_.of_file(file_of_name(texture->image, path_, folder_), texture->image))
        paint = {loaded->mean, SurfaceTexture{loaded->index, texture->wrap, texture->wrap}, paint.transparent,
                 texture->image};
      break;
    }
    return paint;
  }

  const std::string& path_;
  std::filesystem::path folder_;
  std::optional<EarthFrame>& earth_;
  TextureImages& images_;
  SceneBuilder& builder_;
  GmlAppearance appearance_;
  bool geographic_ = false;
  bool crs_set_ = false;
  std::unordered_map<std::string_view, pugi::xml_node> ids_;
  std::vector<std::unique_ptr<glm::dmat4>> placements_;  // of the feature being read
  Polygon polygon_;                                      // reused
  std::vector<glm::vec2> texcoords_;                     // of its points
  bool textured_ = false;                                // every ring has them
  std::vector<std::array<std::uint32_t, 3>> cut_;        // reused
};

}  // namespace

Status import_citygml(std::vector<std::byte> bytes, const std::string& path, std::optional<EarthFrame>& earth,
                      TextureImages& images, SceneBuilder& builder) {
  pugi::xml_document document;
  const pugi::xml_parse_result parsed = document.load_buffer_inplace(bytes.data(), bytes.size());
  if (!parsed)
    return Error{ErrorCode::kFormat, "invalid XML: " + one_line(parsed.description()), path,
                 static_cast<std::int64_t>(parsed.offset)};
  const pugi::xml_node model = document.document_element();
  if (local_name(model) != "CityModel")
    return Error{ErrorCode::kUnsupported, "XML whose root is " + one_line(model.name()) + ", not a CityModel", path, 0};
  for (const pugi::xml_attribute& attribute : model.attributes()) {
    const std::string_view value = attribute.value();
    const std::string_view prefix = "http://www.opengis.net/citygml/";
    if (!value.starts_with(prefix)) continue;
    if (!value.ends_with("/2.0") && !value.ends_with("/1.0"))
      return Error{ErrorCode::kUnsupported, "CityGML '" + one_line(value) + "', only 1.0 and 2.0 are read", path, 0};
  }
  return CityGmlImport(path, earth, images, builder).run(model);
}

}  // namespace zc
