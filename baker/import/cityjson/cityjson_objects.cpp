// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/import/cityjson/cityjson_objects.h"

#include <charconv>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <unordered_set>

#include "baker/import/cityjson/cityjson_geometry.h"
#include "baker/import/shared/json_text.h"
#include "baker/import/shared/surface_material.h"

namespace zc {
namespace {

using nlohmann::json;

// Below this a level of detail is a footprint, which its parts' own ground replaces.
constexpr double kFirstSolidLod = 1.0;

struct Plan {
  std::string type;
  double lod = -1;                  // of the chosen geometry
  std::vector<const json*> chosen;  // entries of "geometry" at the highest level
  std::string parent;               // in the same document, empty when none
  std::string owner;                // the object in the scene, once it is known
  bool in_circle = false;           // of parents, or below one
};

std::string type_of(const json& value) {
  const json* type = find_member(value, "type");
  return type != nullptr && type->is_string() ? type->get<std::string>() : "";
}

class ObjectsReader {
 public:
  ObjectsReader(const CityHeader& header, const CitySource& source, TextureImages& images, SceneBuilder& builder)
      : header_(header), source_(source), images_(images), builder_(builder) {}

  Status run(const json& document) {
    const json* objects = find_member(document, "CityObjects");
    if (objects == nullptr || !objects->is_object()) return source_.error("CityObjects is missing or not an object");
    const json* vertices = find_member(document, "vertices");
    if (vertices == nullptr) return source_.error("vertices is missing");
    ZC_ASSIGN(vertices_, read_city_vertices(*vertices, header_.transform, source_));
    for (glm::dvec3& vertex : vertices_) {
      ZC_ASSIGN(vertex, builder_.placement().to_metric(vertex, source_.path));
    }
    // The document itself was read as the header; a feature may bring its own appearance.
    if (document.contains("appearance") && type_of(document) == "CityJSONFeature") {
      ZC_ASSIGN(own_appearance_, read_city_appearance(document, source_));
    }
    for (const auto& [id, object] : objects->items()) {
      ZC_ASSIGN(Plan plan, plan_of(id, object, *objects));
      plans_.emplace(id, std::move(plan));
    }
    drop_footprints();
    std::map<std::string, std::vector<std::string>> members;  // object in the scene -> city objects in it
    for (const auto& [id, plan] : plans_)
      if (!plan.chosen.empty()) members[owner_of(id)].push_back(id);
    for (const auto& [owner, ids] : members) ZC_TRY(add_object(owner, ids));
    return {};
  }

 private:
  Result<Plan> plan_of(const std::string& id, const json& object, const json& objects) {
    builder_.enter_object(id);
    Plan plan;
    plan.type = type_of(object);
    if (plan.type.empty()) return source_.object_error(id, "has no type");
    if (const json* parents = find_member(object, "parents"); parents != nullptr) {
      if (!parents->is_array()) return source_.object_error(id, "parents is not an array");
      for (const json& parent : *parents) {
        if (!parent.is_string()) return source_.object_error(id, "a parent is not text");
        const auto found = objects.find(parent.get_ref<const std::string&>());
        // A group's members stay objects of their own.
        if (plan.parent.empty() && found != objects.end() && type_of(*found) != "CityObjectGroup")
          plan.parent = parent.get<std::string>();
      }
    }
    const json* geometries = find_member(object, "geometry");
    if (geometries == nullptr) return plan;
    if (!geometries->is_array()) return source_.object_error(id, "geometry is not an array");
    for (const json& geometry : *geometries) {
      if (!geometry.is_object()) return source_.object_error(id, "a geometry is not an object");
      ZC_ASSIGN(const json* shape, shape_of(id, geometry));
      const auto surfaces = has_surfaces(type_of(*shape));
      if (!surfaces) return source_.object_error(id, "geometry of unknown type '" + one_line(type_of(*shape)) + "'");
      if (!*surfaces) {
        builder_.note("geometries of points or lines, left out");
        continue;
      }
      ZC_ASSIGN(const double lod, lod_of(id, *shape));
      if (plan.chosen.empty() || lod > plan.lod) {
        plan.chosen.clear();
        plan.lod = lod;
      }
      if (lod == plan.lod) plan.chosen.push_back(&geometry);
    }
    return plan;
  }

  // The geometry itself, or the template that an instance names.
  [[nodiscard]] Result<const json*> shape_of(const std::string& id, const json& geometry) const {
    if (type_of(geometry) != "GeometryInstance") return &geometry;
    const json* index = find_member(geometry, "template");
    const auto number = index != nullptr ? as_unsigned(*index) : std::nullopt;
    if (!number || *number >= header_.templates.size())
      return source_.object_error(
          id, "geometry template out of range (" + std::to_string(header_.templates.size()) + " templates)");
    if (!header_.templates[*number].is_object())
      return source_.object_error(id, "geometry template " + std::to_string(*number) + " is not an object");
    return &header_.templates[*number];
  }

  [[nodiscard]] Result<double> lod_of(const std::string& id, const json& geometry) const {
    const json* lod = find_member(geometry, "lod");
    if (lod == nullptr) return -1.0;
    if (lod->is_number()) return lod->get<double>();
    double value = 0;
    if (lod->is_string()) {
      const std::string& text = lod->get_ref<const std::string&>();
      const auto [end, fault] = std::from_chars(text.data(), text.data() + text.size(), value);
      if (fault == std::errc() && end == text.data() + text.size()) return value;
    }
    return source_.object_error(
        id, "lod " + one_line(lod->dump(-1, ' ', false, json::error_handler_t::replace)) + " is not a number");
  }

  void drop_footprints() {
    for (const auto& [id, plan] : plans_) {
      const auto parent = plans_.find(plan.parent);
      if (plan.chosen.empty() || plan.lod < kFirstSolidLod || parent == plans_.end()) continue;
      if (parent->second.chosen.empty() || parent->second.lod < 0 || parent->second.lod >= kFirstSolidLod) continue;
      parent->second.chosen.clear();
      builder_.enter_object(plan.parent);
      builder_.remark("footprints whose parts have solid geometry, left out");
    }
  }

  // The outermost ancestor reached through parents that have geometry at the same level; the object itself where they
  // go round in a circle. Every step up is taken once.
  const std::string& owner_of(const std::string& id) {
    std::vector<std::string> below;
    std::unordered_set<std::string> passed;
    std::string owner = id;
    bool in_circle = false;
    while (true) {
      const Plan& plan = plans_.at(owner);
      in_circle = plan.in_circle || !passed.insert(owner).second;
      if (in_circle) break;
      if (!plan.owner.empty()) {
        owner = plan.owner;
        break;
      }
      below.push_back(owner);
      const auto parent = plans_.find(plan.parent);
      if (parent == plans_.end() || parent->second.chosen.empty() || parent->second.lod != plan.lod) break;
      owner = plan.parent;
    }
    for (const std::string& member : below) {
      Plan& plan = plans_.at(member);
      plan.owner = in_circle ? member : owner;
      plan.in_circle = in_circle;
    }
    return plans_.at(id).owner;
  }

  Status add_object(const std::string& owner, const std::vector<std::string>& ids) {
    ObjectMesh mesh;
    mesh.id = owner;
    mesh.type = plans_.at(owner).type;
    mesh.kind = kind_of_city_object(mesh.type);
    for (const std::string& id : ids) {
      const Plan& plan = plans_.at(id);
      const CityObjectRef object{id, plan.type, owner};
      builder_.enter_object(id);
      for (const json* geometry : plan.chosen) ZC_TRY(add_geometry(*geometry, object, mesh));
    }
    return builder_.add(mesh);
  }

  Status add_geometry(const json& geometry, const CityObjectRef& object, ObjectMesh& mesh) {
    if (type_of(geometry) != "GeometryInstance") {
      const CityContext context{source_, vertices_, own_appearance_ ? *own_appearance_ : header_.appearance, images_,
                                builder_};
      return add_city_geometry(geometry, context, object, nullptr, mesh);
    }
    ZC_ASSIGN(const json* shape, shape_of(object.id, geometry));
    ZC_ASSIGN(const glm::dmat4 placement, placement_of(object.id, geometry));
    const CityContext context{source_, header_.template_vertices, header_.appearance, images_, builder_};
    return add_city_geometry(*shape, context, object, &placement, mesh);
  }

  // Row-major matrix, then the reference point that "boundaries" names.
  [[nodiscard]] Result<glm::dmat4> placement_of(const std::string& id, const json& geometry) const {
    const json* matrix = find_member(geometry, "transformationMatrix");
    if (matrix == nullptr || !matrix->is_array() || matrix->size() != 16)
      return source_.object_error(id, "geometry instance has no transformationMatrix of 16 numbers");
    glm::dmat4 placement(1);
    for (std::size_t i = 0; i < 16; ++i) {
      if (!(*matrix)[i].is_number())
        return source_.object_error(id, "transformationMatrix contains something but numbers");
      placement[static_cast<int>(i % 4)][static_cast<int>(i / 4)] = (*matrix)[i].get<double>();
    }
    const json* boundaries = find_member(geometry, "boundaries");
    const auto point = boundaries != nullptr && boundaries->is_array() && boundaries->size() == 1
                           ? as_unsigned((*boundaries)[0])
                           : std::nullopt;
    if (!point || *point >= vertices_.size())
      return source_.object_error(
          id, "geometry instance has no valid reference point (" + std::to_string(vertices_.size()) + " vertices)");
    placement[3] += glm::dvec4(vertices_[*point], 0);
    return placement;
  }

  const CityHeader& header_;
  const CitySource& source_;
  TextureImages& images_;
  SceneBuilder& builder_;
  std::vector<glm::dvec3> vertices_;
  std::optional<CityAppearance> own_appearance_;
  std::map<std::string, Plan> plans_;  // by id: the order of objects in the scene
};

}  // namespace

Status add_city_objects(const json& document, const CityHeader& header, const CitySource& source, TextureImages& images,
                        SceneBuilder& builder) {
  return ObjectsReader(header, source, images, builder).run(document);
}

}  // namespace zc
