// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/import/citygml/citygml_features.h"

#include <algorithm>
#include <unordered_set>
#include <utility>

#include "baker/import/citygml/citygml_names.h"
#include "baker/import/citygml/gml_xml.h"

namespace zc {
namespace {

constexpr const char* kInteriors = "rooms and what stands in them, left out";
constexpr const char* kEmptySpaces = "spaces that are empty, for traffic and clearance, left out";

bool is_polygon(std::string_view name) {
  return name == "Polygon" || name == "PolygonPatch" || name == "Triangle" || name == "Rectangle";
}

// Where 3.0 has no element of its own for what stands inside.
bool stands_inside(const pugi::xml_node& part) {
  return gml_text(gml_child(part, "relationToConstruction")) == "inside";
}

void append(std::vector<std::string_view>& ids, const std::vector<std::string_view>& more) {
  ids.insert(ids.end(), more.begin(), more.end());
}

}  // namespace

Result<std::vector<FoundFeature>> CityGmlFeatures::read(const pugi::xml_node& object) {
  own_templates_.clear();
  placements_.clear();
  const std::string_view name = local_name(object);
  if (const GmlRole role = role_of(name); role == GmlRole::kInterior || role == GmlRole::kEmptySpace) {
    if (role == GmlRole::kInterior)
      builder_.note(kInteriors);
    else
      builder_.remark(kEmptySpaces);
    return std::vector<FoundFeature>();
  }
  std::vector<Feature> features = {{object, object_type(name), std::nullopt, -1, {}}};
  for (std::size_t i = 0; i < features.size(); ++i) {
    const pugi::xml_node node = features[i].node;
    const std::string_view own = local_name(node);
    Inherited above;
    if (i > 0) above.surface = surface_of_name(own);
    above.in_traffic_space = is_traffic_space(own);
    Gathered found;
    ZC_TRY(gather_children(node, above, std::nullopt, found));
    for (const pugi::xml_node& part : found.parts) {
      const std::string_view kind = local_name(part);
      features.push_back({part, is_traffic_space(kind) ? features[i].type : object_type(kind), i, -1, {}});
    }
    features[i].found = std::move(found);
  }
  choose_levels(features);
  ZC_TRY(follow_references(object, features));
  std::vector<FoundFeature> found;
  for (Feature& feature : features)
    if (feature.lod >= 0)
      found.push_back(
          {std::move(feature.type), std::move(feature.found.by_lod[static_cast<std::size_t>(feature.lod)])});
  return found;
}

Status CityGmlFeatures::gather_children(const pugi::xml_node& node, Inherited above, std::optional<int> lod,
                                        Gathered& out) {
  if (const std::string_view id = gml_attribute(node, "id"); !id.empty()) above.ids.insert(above.ids.begin(), id);
  for (const pugi::xml_node& child : node.children())
    if (child.type() == pugi::node_element) ZC_TRY(gather(child, above, lod, out));
  return {};
}

Status CityGmlFeatures::gather(const pugi::xml_node& node, const Inherited& above, std::optional<int> lod,
                               Gathered& out) {
  const std::string_view name = local_name(node);
  const std::optional<int> own_lod = lod_of(name);
  switch (role_of(name)) {
    case GmlRole::kNoShape:
      return {};
    case GmlRole::kInterior:
      builder_.note(kInteriors);
      return {};
    case GmlRole::kEmptySpace:
      builder_.remark(kEmptySpaces);
      return {};
    case GmlRole::kPart:
      if (stands_inside(node))
        builder_.note(kInteriors);
      else
        out.parts.push_back(node);
      return {};
    case GmlRole::kPlain:
      break;
  }
  if (above.in_logical_space && (own_lod || name == "boundary")) return {};
  if (above.in_traffic_space && (name == "ClosureSurface" || (own_lod && name.ends_with("Solid")))) {
    builder_.remark(kEmptySpaces);
    return {};
  }
  if (is_polygon(name)) {
    if (!lod) return {};  // an envelope, say
    FoundPolygon found{node, above.surface, above.ids, above.flipped};
    if (const std::string_view id = gml_attribute(node, "id"); !id.empty()) found.ids.insert(found.ids.begin(), id);
    out.by_lod[static_cast<std::size_t>(*lod)].push_back(std::move(found));
    return {};
  }
  const std::optional<int> level = own_lod ? own_lod : lod;
  Inherited below = above;
  if (const auto surface = surface_of_name(name)) below.surface = surface;
  if (name == "OrientableSurface" && gml_attribute(node, "orientation") == "-") below.flipped = !below.flipped;
  below.in_logical_space = above.in_logical_space || is_logical_space(name);
  if (name == "ImplicitGeometry") return level ? gather_implicit(node, below, *level, out) : Status();
  if (const std::string_view href = gml_attribute(node, "href"); level && href.starts_with('#') && !node.first_child())
    out.references.push_back({href.substr(1), *level, below});
  const std::size_t before = level ? out.by_lod[static_cast<std::size_t>(*level)].size() : 0;
  ZC_TRY(gather_children(node, std::move(below), level, out));
  const bool is_tin = name == "Tin" || name == "TriangulatedSurface";
  if (is_tin && level && out.by_lod[static_cast<std::size_t>(*level)].size() == before)
    builder_.note("terrain of points that are not joined to triangles, left out");
  return {};
}

// A geometry in a frame of its own: a matrix by rows, then a point of the model's frame.
Status CityGmlFeatures::gather_implicit(const pugi::xml_node& node, const Inherited& above, int lod, Gathered& out) {
  if (above.in_template) {  // the standard has none there, and without it nothing grows with every level
    builder_.note("implicit geometries within implicit geometries, left out");
    return {};
  }
  glm::dmat4 placement(1);
  if (const pugi::xml_node matrix = gml_child(node, "transformationMatrix")) {
    ZC_ASSIGN(const std::vector<double> numbers, gml_numbers(matrix, path_));
    if (numbers.size() != 16) return gml_error(matrix, "transformationMatrix has not 16 numbers", path_);
    for (std::size_t i = 0; i < 16; ++i) placement[static_cast<int>(i % 4)][static_cast<int>(i / 4)] = numbers[i];
  }
  const pugi::xml_node point = gml_child(gml_child(node, "referencePoint"), "Point");
  ZC_ASSIGN(const std::vector<glm::dvec3> at, geometry_.points_of(point));
  if (at.size() != 1) return gml_error(node, "an implicit geometry has no reference point", path_);
  ZC_ASSIGN(const glm::dvec3 world, geometry_.to_metric(at[0], node));
  placement[3] += glm::dvec4(world, 0);
  pugi::xml_node property = gml_child(node, "relativeGMLGeometry");
  if (!property) property = gml_child(node, "relativeGeometry");  // of 3.0
  if (!property) {
    builder_.note("implicit geometries in files of their own, left out");
    return {};
  }
  ZC_ASSIGN(const Template* shape, template_of(property));
  if (shape == nullptr) return {};
  if (shape->cost > placements_left_)
    return Error{ErrorCode::kBudget,
                 "implicit geometries are placed so often that their corners outgrow the file, expected no more than " +
                     std::to_string(kPlacements) + " and " + std::to_string(kPlacementsPerByte) +
                     " for each of its bytes; split it into several files",
                 path_, static_cast<std::int64_t>(node.offset_debug())};
  placements_left_ -= shape->cost;
  placements_.push_back(placement);
  std::vector<FoundPolygon>& polygons = out.by_lod[static_cast<std::size_t>(lod)];
  for (FoundPolygon polygon : shape->polygons) {
    if (!polygon.surface) polygon.surface = above.surface;
    append(polygon.ids, above.ids);
    polygon.flipped = polygon.flipped != above.flipped;
    polygon.placement = &placements_.back();
    polygons.push_back(std::move(polygon));
  }
  return {};
}

// Null where it is not in the file.
Result<const CityGmlFeatures::Template*> CityGmlFeatures::template_of(const pugi::xml_node& property) {
  const std::string_view href = gml_attribute(property, "href");
  if (!href.starts_with('#')) {
    ZC_ASSIGN(Template own, read_template(property));
    own.cost = 0;  // the file has it here and nowhere else
    return &own_templates_.emplace_back(std::move(own));
  }
  const pugi::xml_node geometry = by_id(href.substr(1));
  if (!geometry) {
    builder_.note("references to geometry that is not in the file, left out");
    return nullptr;
  }
  const auto known = templates_.find(geometry.internal_object());
  if (known != templates_.end()) return &known->second;
  ZC_ASSIGN(Template shared, read_template(geometry));
  return &templates_.emplace(geometry.internal_object(), std::move(shared)).first->second;
}

Result<CityGmlFeatures::Template> CityGmlFeatures::read_template(const pugi::xml_node& geometry) {
  Template shape;
  Inherited above;
  above.in_template = true;
  Gathered found;
  ZC_TRY(gather(geometry, above, 0, found));
  if (!found.references.empty())
    builder_.note("references within implicit geometries, left out", found.references.size());
  for (std::vector<FoundPolygon>& polygons : found.by_lod)
    for (FoundPolygon& polygon : polygons) {
      ZC_ASSIGN(std::vector<GmlRing> rings, geometry_.rings_of(polygon.node));
      shape.cost += 1;
      for (const GmlRing& ring : rings) shape.cost += ring.points.size();
      polygon.rings = &shape.rings.emplace_back(std::move(rings));
      shape.polygons.push_back(std::move(polygon));
    }
  return shape;
}

// Of every element with an id, found on first use. The first of two counts.
pugi::xml_node CityGmlFeatures::by_id(std::string_view id) {
  if (ids_.empty())
    walk_gml(model_, [&](const pugi::xml_node& node) {
      if (const std::string_view own = gml_attribute(node, "id"); !own.empty()) ids_.try_emplace(own, node);
      return true;
    });
  const auto found = ids_.find(id);
  return found != ids_.end() ? found->second : pugi::xml_node();
}

void CityGmlFeatures::choose_levels(std::vector<Feature>& features) {
  for (Feature& feature : features) {
    feature.lod = kMaxLod;
    while (feature.lod >= 0 && feature.found.by_lod[static_cast<std::size_t>(feature.lod)].empty()) --feature.lod;
    if (feature.lod < 0 && !feature.found.by_lod[4].empty()) {
      feature.lod = 4;
      builder_.note("features with LoD4 alone, shown without their interiors");
    }
  }
  // What parts show in more detail, the feature around them does not show again: footprints, and areas of roads.
  std::vector<int> below(features.size(), -1);
  for (std::size_t i = features.size(); i-- > 1;) {
    int& of_parent = below[*features[i].parent];
    of_parent = std::max({of_parent, below[i], features[i].lod});
  }
  for (std::size_t i = 0; i < features.size(); ++i) {
    Feature& feature = features[i];
    const bool hidden = feature.lod == 0 || is_traffic_space(local_name(feature.node));
    if (feature.lod < 0 || !hidden || below[i] <= feature.lod) continue;
    feature.lod = -1;
    builder_.remark("footprints and areas whose parts have more detail, left out");
  }
}

// Solids and surfaces refer to polygons that are written elsewhere in the object. Most of them are shown already: then
// the reference may know what surface they are. The standard allows no reference to another object's.
Status CityGmlFeatures::follow_references(const pugi::xml_node& object, std::vector<Feature>& features) {
  std::vector<std::pair<std::size_t, Reference>> queue;
  std::unordered_map<const void*, std::pair<std::size_t, std::size_t>> shown;  // feature, place among its polygons
  for (std::size_t f = 0; f < features.size(); ++f)
    for (Reference& reference : features[f].found.references)
      if (reference.lod == features[f].lod) queue.emplace_back(f, std::move(reference));
  if (queue.empty()) return {};
  std::stable_partition(queue.begin(), queue.end(), [](const auto& entry) { return entry.second.above.surface; });
  const auto polygons_of = [&](std::size_t f) -> std::vector<FoundPolygon>& {
    return features[f].found.by_lod[static_cast<std::size_t>(features[f].lod)];
  };
  for (std::size_t f = 0; f < features.size(); ++f)
    for (std::size_t p = 0; features[f].lod >= 0 && p < polygons_of(f).size(); ++p)
      shown.try_emplace(polygons_of(f)[p].node.internal_object(), f, p);
  std::unordered_map<std::string_view, pugi::xml_node> ids;
  walk_gml(object, [&](const pugi::xml_node& node) {
    if (const std::string_view id = gml_attribute(node, "id"); !id.empty()) ids.try_emplace(id, node);
    return true;
  });
  std::unordered_set<const void*> visited;
  for (std::size_t i = 0; i < queue.size(); ++i) {
    const auto [f, reference] = queue[i];
    const auto target = ids.find(reference.id);
    if (target == ids.end()) {
      builder_.note("references to surfaces outside of their object, left out");
      continue;
    }
    if (!visited.insert(target->second.internal_object()).second) continue;
    Gathered found;
    ZC_TRY(gather(target->second, reference.above, reference.lod, found));
    for (FoundPolygon& polygon : found.by_lod[static_cast<std::size_t>(reference.lod)]) {
      const auto [slot, is_new] = shown.try_emplace(polygon.node.internal_object(), f, polygons_of(f).size());
      if (is_new) {
        polygons_of(f).push_back(std::move(polygon));
      } else {
        FoundPolygon& other = polygons_of(slot->second.first)[slot->second.second];
        if (!other.surface) other.surface = polygon.surface;
      }
    }
    for (Reference& further : found.references)
      if (further.lod == reference.lod) queue.emplace_back(f, std::move(further));
  }
  return {};
}

}  // namespace zc
