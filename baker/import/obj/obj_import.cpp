// SPDX-License-Identifier: GPL-3.0-or-later
// Wavefront "Object Files", version 3.0, of its polygonal part.
#include "baker/import/obj/obj_import.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <glm/common.hpp>
#include <map>
#include <optional>
#include <utility>

#include "baker/import/obj/obj_materials.h"
#include "baker/import/shared/opaque_part.h"
#include "baker/import/shared/polygon.h"
#include "baker/import/shared/surface_material.h"
#include "baker/import/shared/text_words.h"
#include "baker/import/shared/up_axis.h"
#include "baker/import/shared/vertex_colors.h"
#include "base/text.h"

namespace zc {
namespace {

constexpr std::size_t kMaxVertices = 0xFFFF'FFFE;
constexpr std::uint32_t kNone = 0xFFFF'FFFF;
// Of what is cut out of all transparent parts of a file: pieces, and texels that are looked at; so many, and more for
// each byte of the file.
constexpr std::uint64_t kMaxPieces = 1U << 20U;
constexpr std::uint64_t kPiecesPerByte = 4;
constexpr double kMaxTexels = 1U << 29U;
constexpr double kTexelsPerByte = 1 << 11;
constexpr double kMaxTexelsAtOnce = 1 << 24;  // beyond it AlphaMask takes a coarser level
constexpr float kMaskSide = 512;

struct Corner {
  std::uint32_t vertex = kNone;
  std::uint32_t texcoord = kNone;
};

// Triangles whose material is transparent in part, until it is known what is left of them.
struct CoveredPart {
  const ObjMaterial* material = nullptr;
  std::vector<glm::dvec3> positions;
  std::vector<std::array<std::uint32_t, 3>> triangles;
  std::vector<glm::vec2> texcoords;
  std::vector<std::uint16_t> materials;
  double texels = 0;  // about so many does the cut look at
};

class ObjImport {
 public:
  ObjImport(std::string_view text, const std::string& path, const InputFiles& files, TextureImages& images,
            SceneBuilder& builder)
      : text_(text), path_(path), builder_(builder), materials_(path, files, images, builder) {}

  Status run() {
    ZC_TRY(read_vertices());
    ZC_TRY(read_faces());
    if (other_elements_ > 0) builder_.note("OBJ points, lines and free-form surfaces, left out", other_elements_);
    if (panes_ > 0) builder_.note("transparent OBJ surfaces, kept as panes that are opaque", panes_);
    materials_.report();
    return {};
  }

 private:
  [[nodiscard]] Error error(const TextWords& words, std::string message) const {
    return {ErrorCode::kFormat, std::move(message), path_, static_cast<std::int64_t>(words.offset())};
  }

  // Numbers up to the end of the line, of which there are so many at least and at most kNumbers are kept.
  static constexpr std::size_t kNumbers = 8;
  Result<std::size_t> numbers(TextWords& words, std::size_t least, std::array<double, kNumbers>& out) const {
    std::size_t count = 0;
    for (std::string_view word = words.word(); !word.empty() && count < kNumbers; word = words.word()) {
      const std::optional<double> number = number_of(word);
      if (!number)
        return error(words, "'" + printable(word, 40) + "' is no number, expected one with a point; export it anew");
      out[count++] = *number;
    }
    if (count < least)
      return error(words, "has " + std::to_string(count) + " numbers, expected " + std::to_string(least) +
                              " or more; export it anew");
    return count;
  }

  // All of them, before the faces that name them: and of these some come first in the file.
  Status read_vertices() {
    const glm::dmat3 turned(upright(kUpWithoutRule));
    std::array<double, kNumbers> value{};
    std::size_t objects = 0;
    float brightest = 0;
    for (TextWords words(text_, true); words.next_line();) {
      const std::string_view key = words.word();
      if (key == "v") {
        ZC_ASSIGN(const std::size_t count, numbers(words, 3, value));
        if (positions_.size() == kMaxVertices)
          return Error{ErrorCode::kUnsupported, "has more than 2^32 vertices; split it", path_};
        positions_.push_back(turned * glm::dvec3(value[0], value[1], value[2]));
        if (count < 6) {
          if (!colors_.empty()) colors_.emplace_back(1);
          continue;
        }
        // x y z r g b, or with a weight before the colour.
        colors_.resize(positions_.size(), glm::vec3(1));
        colors_.back() = glm::vec3(value[count - 3], value[count - 2], value[count - 1]);
        for (int c = 0; c < 3; ++c) brightest = std::max(brightest, colors_.back()[c]);
      } else if (key == "vt") {
        ZC_ASSIGN(const std::size_t count, numbers(words, 1, value));
        texcoords_.emplace_back(value[0], count > 1 ? value[1] : 0.0);
        if (texcoords_.size() > kMaxVertices)
          return Error{ErrorCode::kUnsupported, "has more than 2^32 texture coordinates; split it", path_};
      } else if (key == "o") {
        ++objects;
      } else if (key == "mtllib") {
        materials_.add_library(words.rest());
      }
    }
    by_groups_ = objects < 2;
    if (brightest > 1)  // some programs write bytes
      for (glm::vec3& color : colors_) color /= 255.0F;
    limit_colors(colors_);
    local_.assign(positions_.size(), kNone);
    return {};
  }

  Status read_faces() {
    constexpr std::array<std::string_view, 6> kOthers = {"p", "l", "curv", "curv2", "surf", "call"};
    object_.id = std::filesystem::path(path_).stem().string();
    material_ = &materials_.find({});
    std::vector<Corner> corners;
    std::size_t vertices = 0;
    std::size_t texcoords = 0;
    for (TextWords words(text_, true); words.next_line();) {
      const std::string_view key = words.word();
      if (key == "v") {
        ++vertices;
      } else if (key == "vt") {
        ++texcoords;
      } else if (key == "f") {
        corners.clear();
        for (std::string_view word = words.word(); !word.empty(); word = words.word()) {
          ZC_ASSIGN(const Corner corner, corner_of(word, vertices, texcoords, words));
          corners.push_back(corner);
        }
        add_face(corners);
      } else if (key == "usemtl") {
        material_ = &materials_.find(words.rest());
        plain_.reset();
      } else if (key == (by_groups_ ? "g" : "o") || key == "o") {
        ZC_TRY(end_object());
        if (const std::string_view name = words.rest(); !name.empty()) object_.id = name;
      } else if (std::find(kOthers.begin(), kOthers.end(), key) != kOthers.end()) {
        ++other_elements_;
      }
    }
    return end_object();
  }

  // "vertex", "vertex/texcoord", "vertex//normal" or "vertex/texcoord/normal", each from 1, or from -1 backwards.
  Result<Corner> corner_of(std::string_view word, std::size_t vertices, std::size_t texcoords,
                           const TextWords& words) const {
    const auto index = [&](std::string_view part, std::size_t before, std::size_t all) -> std::optional<std::uint32_t> {
      const std::optional<long long> number = integer_of(part);
      if (!number || *number == 0) return std::nullopt;
      const long long at = *number > 0 ? *number - 1 : static_cast<long long>(before) + *number;
      if (at < 0 || at >= static_cast<long long>(all)) return std::nullopt;
      return static_cast<std::uint32_t>(at);
    };
    const std::size_t slash = word.find('/');
    const auto vertex = index(word.substr(0, slash), vertices, positions_.size());
    if (!vertex)
      return error(words, "a face names the vertex '" + printable(word, 40) + "', expected one of the " +
                              std::to_string(positions_.size()) + " that there are; export it anew");
    Corner corner{*vertex, kNone};
    if (slash == std::string_view::npos) return corner;
    const std::string_view behind = word.substr(slash + 1);
    const std::string_view texcoord = behind.substr(0, behind.find('/'));
    if (texcoord.empty()) return corner;
    const auto found = index(texcoord, texcoords, texcoords_.size());
    if (!found)
      return error(words, "a face names the texture coordinates '" + printable(word, 40) + "', expected one of the " +
                              std::to_string(texcoords_.size()) + " that there are; export it anew");
    corner.texcoord = *found;
    return corner;
  }

  void add_face(const std::vector<Corner>& corners) {
    if (corners.size() < 3) {
      builder_.note(loss_of(PolygonOutcome::kNoArea));
      return;
    }
    polygon_.clear();
    for (const Corner& corner : corners) polygon_.add_point(positions_[corner.vertex]);
    polygon_.end_ring();
    cut_.clear();
    if (corners.size() == 3) cut_.push_back({0, 1, 2});  // what the scene cannot use it counts by itself
    if (corners.size() > 3)
      if (const char* loss = loss_of(triangulate_polygon(polygon_, cut_).outcome)) builder_.note(loss);
    uv_.clear();
    if (std::none_of(corners.begin(), corners.end(), [](const Corner& corner) { return corner.texcoord == kNone; })) {
      for (const Corner& corner : corners) {
        const glm::vec2 uv = texcoords_[corner.texcoord] * material_->uv_scale + material_->uv_offset;
        uv_.emplace_back(uv.x, 1 - uv.y);  // upwards in the file
      }
      for (const Polygon::Crossing& crossing : polygon_.crossings)
        uv_.push_back(glm::mix(uv_[crossing.from], uv_[crossing.to], static_cast<float>(crossing.part)));
    }
    for (const auto& triangle : cut_) add_triangle(triangle, corners);
  }

  // Of the polygon's points, of which those behind the corners are places where its outline crosses itself.
  void add_triangle(const std::array<std::uint32_t, 3>& points, const std::vector<Corner>& all) {
    std::array<Corner, 3> corners;  // of a crossing, that where its edge begins
    for (std::size_t k = 0; k < 3; ++k) {
      std::uint32_t at = points[k];
      while (at >= all.size()) at = polygon_.crossings[at - all.size()].from;
      corners[k] = all[at];
    }
    const bool has_uv = !uv_.empty();
    std::array<glm::vec2, 3> uv{};
    for (std::size_t k = 0; has_uv && k < 3; ++k) uv[k] = uv_[points[k]];
    const std::uint16_t material = material_of(corners);
    const bool is_covered = material_->coverage && has_uv && material_->coverage->mask != nullptr;
    if (material_->coverage && !is_covered && material_->coverage->factor < material_->coverage->cutoff) ++panes_;
    if (is_covered) {
      CoveredPart& part = covered_[{material_->number, material}];
      part.material = material_;
      const auto first = static_cast<std::uint32_t>(part.positions.size());
      for (std::size_t k = 0; k < 3; ++k) {
        part.positions.push_back(polygon_.points[points[k]]);
        part.texcoords.push_back(uv[k]);
      }
      const glm::vec2 low = glm::min(uv[0], glm::min(uv[1], uv[2]));
      const glm::vec2 size = (glm::max(uv[0], glm::max(uv[1], uv[2])) - low) * kMaskSide;
      part.texels += size.x * size.y;
      part.triangles.push_back({first, first + 1, first + 2});
      part.materials.push_back(material);
      return;
    }
    std::array<std::uint32_t, 3> triangle{};
    for (std::size_t k = 0; k < 3; ++k) {
      // A crossing is no vertex of the file.
      std::uint32_t* known = points[k] < all.size() ? &local_[corners[k].vertex] : nullptr;
      if (known != nullptr && *known != kNone) {
        triangle[k] = *known;
        continue;
      }
      triangle[k] = static_cast<std::uint32_t>(object_.positions.size());
      object_.positions.push_back(polygon_.points[points[k]]);
      if (known == nullptr) continue;
      *known = triangle[k];
      used_.push_back(corners[k].vertex);
    }
    if (has_uv && material_->material.texture)
      object_.texcoords.push_back({static_cast<std::uint32_t>(object_.triangles.size()), uv});
    object_.triangles.push_back(triangle);
    object_.materials.push_back(material);
  }

  std::uint16_t material_of(const std::array<Corner, 3>& corners) {
    if (!colors_.empty() && !material_->material.texture) {
      Material material = material_->material;
      if (!material_->has_color) material.base_color = glm::vec3(1);
      material.base_color *=
          triangle_color(colors_[corners[0].vertex], colors_[corners[1].vertex], colors_[corners[2].vertex]);
      return builder_.material(material);
    }
    if (!plain_) plain_ = builder_.material(material_->material);
    return *plain_;
  }

  void keep_opaque_part(CoveredPart& part) {
    if (pieces_ > kMaxPieces + kPiecesPerByte * text_.size() ||
        texels_ > kMaxTexels + kTexelsPerByte * static_cast<double>(text_.size())) {
      builder_.note("OBJ triangles with transparent parts beyond what a file of its size may have, kept whole",
                    part.triangles.size());
      return;
    }
    keep_opaque(*part.material->coverage, "OBJ", {part.positions, part.triangles, part.texcoords, part.materials},
                builder_);
    pieces_ += part.triangles.size();
    texels_ += part.texels < kMaxTexelsAtOnce ? part.texels : kMaxTexelsAtOnce;  // no number: the most
  }

  Status end_object() {
    for (auto& [index, part] : covered_) {
      keep_opaque_part(part);
      const auto first = static_cast<std::uint32_t>(object_.positions.size());
      object_.positions.insert(object_.positions.end(), part.positions.begin(), part.positions.end());
      object_.materials.insert(object_.materials.end(), part.materials.begin(), part.materials.end());
      for (const auto& [a, b, c] : part.triangles) {
        if (part.material->material.texture)
          object_.texcoords.push_back({static_cast<std::uint32_t>(object_.triangles.size()),
                                       {part.texcoords[a], part.texcoords[b], part.texcoords[c]}});
        object_.triangles.push_back({first + a, first + b, first + c});
      }
    }
    covered_.clear();
    object_.kind = kind_of_name(object_.id);
    if (!object_.triangles.empty()) ZC_TRY(builder_.add(object_));
    for (const std::uint32_t vertex : used_) local_[vertex] = kNone;
    used_.clear();
    object_ = {.id = std::move(object_.id)};
    return {};
  }

  std::string_view text_;
  const std::string& path_;
  SceneBuilder& builder_;
  ObjMaterials materials_;
  std::vector<glm::dvec3> positions_;
  std::vector<glm::vec3> colors_;  // of all vertices, or of none
  std::vector<glm::vec2> texcoords_;
  bool by_groups_ = true;
  std::uint64_t other_elements_ = 0;
  std::uint64_t panes_ = 0;
  std::uint64_t pieces_ = 0;
  double texels_ = 0;

  const ObjMaterial* material_ = nullptr;
  std::optional<std::uint16_t> plain_;  // of material_, in the scene
  ObjectMesh object_;
  std::vector<std::uint32_t> local_;                                        // per vertex: where the object has it
  std::vector<std::uint32_t> used_;                                         // vertices that it has
  std::map<std::pair<std::uint32_t, std::uint16_t>, CoveredPart> covered_;  // of the object, by both materials' numbers
  Polygon polygon_;
  std::vector<glm::vec2> uv_;  // of its points; empty: none
  std::vector<std::array<std::uint32_t, 3>> cut_;
};

}  // namespace

bool is_obj(std::string_view text) {
  constexpr std::array<std::string_view, 15> kKeys = {"v", "vt", "vn", "vp",     "f",      "g",      "o",     "s",
                                                      "p", "l",  "mg", "mtllib", "usemtl", "maplib", "usemap"};
  TextWords words(text, true);
  if (!words.next_line()) return false;
  const std::string_view key = words.word();
  return std::find(kKeys.begin(), kKeys.end(), key) != kKeys.end() && !words.rest().empty();
}

Status import_obj(std::span<const std::byte> bytes, const std::string& path, const InputFiles& files,
                  TextureImages& images, SceneBuilder& builder) {
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  return ObjImport(text, path, files, images, builder).run();
}

}  // namespace zc
