// SPDX-License-Identifier: GPL-3.0-or-later
// Which polygons make up an object: of every feature in it those of its highest level of detail, where they are
// written, where references within the object find them, and where implicit geometries place them.
// Borrows the document. Untrusted input, whose elements nest no deeper than the caller allows: what is referenced is
// read once, and implicit geometries are placed no more often than the file's size allows. Not thread-safe.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <glm/mat4x4.hpp>
#include <optional>
#include <pugixml.hpp>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "baker/import/citygml/gml_geometry.h"
#include "baker/import/shared/scene_builder.h"
#include "baker/import/shared/surface_material.h"
#include "base/result.h"

namespace zc {

struct FoundPolygon {
  pugi::xml_node node;
  std::optional<Surface> surface;     // of the nearest semantic element
  std::vector<std::string_view> ids;  // of the polygon and what it is part of, from the inside
  bool flipped = false;
  const glm::dmat4* placement = nullptr;
  const std::vector<GmlRing>* rings = nullptr;  // where they are read already
};

struct FoundFeature {
  std::string type;  // as surface_of_object() knows it
  std::vector<FoundPolygon> polygons;
};

class CityGmlFeatures {
 public:
  CityGmlFeatures(const pugi::xml_node& model, std::uint64_t file_bytes, const std::string& path, GmlGeometry& geometry,
                  SceneBuilder& builder)
      : model_(model),
        path_(path),
        geometry_(geometry),
        builder_(builder),
        placements_left_(kPlacements + kPlacementsPerByte * file_bytes) {}

  // The object itself, then the features within it. What it points to is valid until the next call.
  Result<std::vector<FoundFeature>> read(const pugi::xml_node& object);

 private:
  // Polygons and their corners that references to implicit geometries may add to those that the file writes out.
  static constexpr std::uint64_t kPlacements = std::uint64_t{1} << 23U;
  static constexpr std::uint64_t kPlacementsPerByte = 4;

  struct Inherited {
    std::optional<Surface> surface;
    std::vector<std::string_view> ids;
    bool flipped = false;
    bool in_traffic_space = false;
    bool in_logical_space = false;
    bool in_template = false;
  };
  struct Reference {
    std::string_view id;
    int lod = 0;
    Inherited above;
  };
  struct Gathered {
    std::array<std::vector<FoundPolygon>, 5> by_lod;
    std::vector<Reference> references;
    std::vector<pugi::xml_node> parts;
  };
  struct Feature {
    pugi::xml_node node;
    std::string type;
    std::optional<std::size_t> parent;  // among those before it
    int lod = -1;                       // that counts; negative where none does
    Gathered found;
  };
  // The shape of an implicit geometry, in its own frame.
  struct Template {
    std::vector<FoundPolygon> polygons;
    std::deque<std::vector<GmlRing>> rings;
    std::uint64_t cost = 0;
  };

  Status gather_children(const pugi::xml_node& node, Inherited above, std::optional<int> lod, Gathered& out);
  Status gather(const pugi::xml_node& node, const Inherited& above, std::optional<int> lod, Gathered& out);
  Status gather_implicit(const pugi::xml_node& node, const Inherited& above, int lod, Gathered& out);
  Result<const Template*> template_of(const pugi::xml_node& property);
  Result<Template> read_template(const pugi::xml_node& geometry);
  void choose_levels(std::vector<Feature>& features);
  Status follow_references(const pugi::xml_node& object, std::vector<Feature>& features);
  pugi::xml_node by_id(std::string_view id);

  const pugi::xml_node model_;
  const std::string& path_;
  GmlGeometry& geometry_;
  SceneBuilder& builder_;
  std::uint64_t placements_left_;
  std::unordered_map<std::string_view, pugi::xml_node> ids_;
  std::unordered_map<const void*, Template> templates_;  // that are referenced; looked up only
  // Of the object being read:
  std::deque<Template> own_templates_;
  std::deque<glm::dmat4> placements_;
};

}  // namespace zc
