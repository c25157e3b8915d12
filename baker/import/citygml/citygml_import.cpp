// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/import/citygml/citygml_import.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/mat4x4.hpp>
#include <glm/matrix.hpp>

#include "baker/import/citygml/citygml_appearance.h"
#include "baker/import/citygml/citygml_features.h"
#include "baker/import/citygml/citygml_names.h"
#include "baker/import/citygml/gml_geometry.h"
#include "baker/import/citygml/gml_xml.h"
#include "baker/import/shared/json_text.h"
#include "baker/import/shared/polygon.h"
#include "baker/import/shared/surface_material.h"
#include "baker/import/shared/uri.h"

namespace zc {
namespace {

// No city model nests deeper than about thirty levels; the reader of features recurses.
constexpr int kMaxDepth = 200;

class CityGmlImport {
 public:
  CityGmlImport(const pugi::xml_node& model, std::uint64_t file_bytes, const std::string& path, const InputFiles& files,
                TextureImages& images, SceneBuilder& builder)
      : model_(model),
        path_(path),
        folder_(folder_of(path)),
        files_(files),
        images_(images),
        builder_(builder),
        geometry_(path, builder),
        features_(model, file_bytes, path, geometry_, builder) {}

  Status run() {
    ZC_TRY(geometry_.enter_model(model_));
    ZC_ASSIGN(appearance_, GmlAppearance::read(model_, path_, builder_));
    for (const pugi::xml_node& member : model_.children()) {
      const std::string_view name = local_name(member);
      if (name != "cityObjectMember" && name != "featureMember" && name != "featureMembers") continue;
      for (const pugi::xml_node& object : member.children())
        if (object.type() == pugi::node_element) ZC_TRY(add_object(object));
    }
    return {};
  }

 private:
  Status add_object(const pugi::xml_node& object) {
    ObjectMesh mesh;
    mesh.id = gml_attribute(object, "id");
    if (mesh.id.empty()) mesh.id = "at byte " + std::to_string(object.offset_debug());
    mesh.type = object_type(local_name(object));
    mesh.kind = kind_of_city_object(mesh.type);
    builder_.enter_object(mesh.id);
    ZC_ASSIGN(const std::vector<FoundFeature> features, features_.read(object));
    if (features.empty()) builder_.note("features without surfaces (points, curves or nothing), left out");
    const std::string palette_key = mesh.id;
    for (const FoundFeature& feature : features)
      for (const FoundPolygon& polygon : feature.polygons)
        ZC_TRY(add_polygon(polygon, feature.type, palette_key, mesh));
    return builder_.add(mesh);
  }

  Status add_ring(const GmlRing& ring, const FoundPolygon& found) {
    const std::vector<glm::vec2>* uv = appearance_.texcoords(gml_attribute(ring.node, "id"));
    if (uv == nullptr || uv->size() < ring.points.size()) {
      textured_ = false;
    } else {
      for (std::size_t i = 0; i < ring.points.size(); ++i) texcoords_.emplace_back((*uv)[i].x, 1 - (*uv)[i].y);
    }
    for (const glm::dvec3& p : ring.points) {
      if (found.placement != nullptr) {
        polygon_.add_point(glm::dvec3(*found.placement * glm::dvec4(p, 1)));
      } else {
        ZC_ASSIGN(const glm::dvec3 world, geometry_.to_metric(p, ring.node));
        polygon_.add_point(world);
      }
    }
    polygon_.end_ring();
    return {};
  }

  Status add_rings(const FoundPolygon& found) {
    polygon_.clear();
    texcoords_.clear();
    textured_ = true;
    if (found.rings != nullptr) {
      for (const GmlRing& ring : *found.rings) ZC_TRY(add_ring(ring, found));
      return {};
    }
    ZC_ASSIGN(const std::vector<GmlRing> rings, geometry_.rings_of(found.node));
    for (const GmlRing& ring : rings) ZC_TRY(add_ring(ring, found));
    return {};
  }

  Status add_polygon(const FoundPolygon& found, const std::string& type, const std::string& palette_key,
                     ObjectMesh& mesh) {
    ZC_TRY(add_rings(found));
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
      if (const auto loaded = images_.of_file(file_of_name(texture->image, path_, folder_), texture->image, files_))
        paint = {loaded->mean, SurfaceTexture{loaded->index, texture->wrap, texture->wrap}, paint.transparent,
                 texture->image};
      break;
    }
    return paint;
  }

  const pugi::xml_node model_;
  const std::string& path_;
  std::filesystem::path folder_;
  const InputFiles& files_;
  TextureImages& images_;
  SceneBuilder& builder_;
  GmlGeometry geometry_;
  CityGmlFeatures features_;
  GmlAppearance appearance_;
  Polygon polygon_;                                // reused
  std::vector<glm::vec2> texcoords_;               // of its points
  bool textured_ = false;                          // every ring has them
  std::vector<std::array<std::uint32_t, 3>> cut_;  // reused
};

// The namespaces of the standard's core, and those of its profiles that lead to it.
Status check_version(const pugi::xml_node& model, const std::string& path, SceneBuilder& builder) {
  constexpr const char* kExpected = "expected a CityModel of CityGML 1.0, 2.0 or 3.0; convert it, or leave it out";
  if (local_name(model) != "CityModel")
    return Error{ErrorCode::kUnsupported,
                 "is XML whose root is " + one_line(model.name()) + ", not a CityModel: " + kExpected, path, 0};
  std::string_view version = namespace_of_root(model);
  if (version.empty()) {
    builder.remark("CityModels without a namespace, read as CityGML 2.0");
    return {};
  }
  for (const std::string_view base :
       {"http://www.opengis.net/citygml/profiles/base/", "http://www.opengis.net/citygml/"})
    if (version.starts_with(base)) {
      const std::string_view number = version.substr(base.size());
      if (number == "1.0" || number == "2.0" || number == "3.0") return {};
    }
  return Error{ErrorCode::kUnsupported, "is a CityModel of '" + one_line(version) + "': " + kExpected, path, 0};
}

Status check_depth(const pugi::xml_node& model, const std::string& path) {
  int depth = 0;
  for (pugi::xml_node node = model; node;) {
    if (node.first_child()) {
      if (++depth > kMaxDepth)
        return gml_error(node,
                         "elements nest deeper than " + std::to_string(kMaxDepth) +
                             ", which no city model needs; export the file anew",
                         path);
      node = node.first_child();
      continue;
    }
    for (; node != model && !node.next_sibling(); --depth) node = node.parent();
    node = node == model ? pugi::xml_node() : node.next_sibling();
  }
  return {};
}

}  // namespace

// What a parser would pass over before it, so that a file need not be parsed, or even be well formed, for its format to
// be recognised.
std::string root_of_xml(std::string_view begin) {
  for (std::size_t at = begin.find('<'); at != std::string_view::npos; at = begin.find('<', at)) {
    const std::string_view rest = begin.substr(at);
    if (rest.starts_with("<?") || rest.starts_with("<!")) {
      const std::string_view end = rest.starts_with("<!--") ? "-->" : rest.starts_with("<?") ? "?>" : ">";
      at = begin.find(end, at);
      if (at == std::string_view::npos) break;
      continue;
    }
    const std::string_view name = rest.substr(1, rest.find_first_of(" \t\r\n/>", 1) - 1);
    if (name.find('\0') != std::string_view::npos) break;  // UTF-16
    return std::string(name.substr(name.find(':') + 1));
  }
  return {};
}

Status import_citygml(std::vector<std::byte> bytes, const std::string& path, const InputFiles& files,
                      TextureImages& images, SceneBuilder& builder) {
  pugi::xml_document document;
  // No document type is read, and so no entity: neither from elsewhere nor one made of others.
  const pugi::xml_parse_result parsed = document.load_buffer_inplace(bytes.data(), bytes.size());
  if (!parsed)
    return Error{ErrorCode::kFormat,
                 "invalid XML: " + one_line(parsed.description()) +
                     ", expected a whole CityGML file; it may be damaged or cut short, get it anew",
                 path, static_cast<std::int64_t>(parsed.offset)};
  const pugi::xml_node model = document.document_element();
  ZC_TRY(check_version(model, path, builder));
  ZC_TRY(check_depth(model, path));
  return CityGmlImport(model, bytes.size(), path, files, images, builder).run();
}

}  // namespace zc
