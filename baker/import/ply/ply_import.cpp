// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/import/ply/ply_import.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <glm/common.hpp>
#include <optional>
#include <utility>

#include "baker/import/ply/ply_reader.h"
#include "baker/import/shared/polygon.h"
#include "baker/import/shared/surface_material.h"
#include "baker/import/shared/up_axis.h"
#include "baker/import/shared/uri.h"
#include "baker/import/shared/vertex_colors.h"

namespace zc {
namespace {

class PlyImport {
 public:
  PlyImport(PlyMesh mesh, const std::string& path, SceneBuilder& builder) : mesh_(std::move(mesh)), builder_(builder) {
    object_.id = std::filesystem::path(path).stem().string();
    object_.kind = kind_of_name(object_.id);
    const glm::dmat3 turned(upright(kUpWithoutRule));
    for (glm::dvec3& position : mesh_.positions) position = turned * position;
    limit_colors(mesh_.colors);
    limit_colors(mesh_.face_colors);
  }

  void load_textures(const std::string& path, const InputFiles& files, TextureImages& images) {
    if (mesh_.texcoords.empty() && mesh_.corner_texcoords.empty()) return;
    for (std::string name : mesh_.texture_files) {
      std::replace(name.begin(), name.end(), '\\', '/');
      const auto image = images.of_file(file_of_name(name, path, folder_of(path)), name, files);
      std::optional<Material>& material = textured_.emplace_back();
      if (!image) continue;
      material = Material{.name = name, .base_color = image->mean};
      material->texture = SurfaceTexture{.image = image->index};
    }
    if (!mesh_.colors.empty() && !textured_.empty()) builder_.note("PLY vertex colours under a texture, left out");
  }

  Status run() {
    if (mesh_.face_ends.empty() && !mesh_.positions.empty())
      builder_.note("PLY vertices without faces (a point cloud), left out", mesh_.positions.size());
    std::uint64_t begin = 0;
    for (std::size_t face = 0; face < mesh_.face_ends.size(); ++face) {
      add_face(face, begin, mesh_.face_ends[face]);
      begin = mesh_.face_ends[face];
    }
    // Behind the vertices are only the crossings of polygons.
    mesh_.positions.insert(mesh_.positions.end(), object_.positions.begin(), object_.positions.end());
    object_.positions = std::move(mesh_.positions);
    return object_.triangles.empty() ? Status() : builder_.add(object_);
  }

 private:
  void add_face(std::size_t face, std::uint64_t begin, std::uint64_t end) {
    const std::size_t count = end - begin;
    if (count < 3) return builder_.note(loss_of(PolygonOutcome::kNoArea));
    polygon_.clear();
    cut_.clear();
    for (std::uint64_t i = begin; i < end; ++i) polygon_.add_point(mesh_.positions[mesh_.corners[i]]);
    polygon_.end_ring();
    if (count == 3) cut_.push_back({0, 1, 2});  // what the scene cannot use it counts by itself
    if (count > 3)
      if (const char* loss = loss_of(triangulate_polygon(polygon_, cut_).outcome)) builder_.note(loss);
    const std::size_t crossings = object_.positions.size();
    for (std::size_t i = count; i < polygon_.points.size(); ++i) object_.positions.push_back(polygon_.points[i]);
    const Material* texture = texture_of(face);
    if (texture != nullptr) read_texcoords(begin, end);
    for (const auto& points : cut_) {
      std::array<std::uint32_t, 3> triangle{};
      std::array<std::uint64_t, 3> corners{};  // of a crossing, that where its edge begins
      for (std::size_t k = 0; k < 3; ++k) {
        std::uint32_t at = points[k];
        triangle[k] = at < count ? mesh_.corners[begin + at]
                                 : static_cast<std::uint32_t>(mesh_.positions.size() + crossings + at - count);
        while (at >= count) at = polygon_.crossings[at - count].from;
        corners[k] = begin + at;
      }
      object_.materials.push_back(texture != nullptr ? builder_.material(*texture) : plain(face, corners));
      if (texture != nullptr)
        object_.texcoords.push_back(
            {static_cast<std::uint32_t>(object_.triangles.size()), {uv_[points[0]], uv_[points[1]], uv_[points[2]]}});
      object_.triangles.push_back(triangle);
    }
  }

  const Material* texture_of(std::size_t face) {
    if (textured_.empty()) return nullptr;
    const std::int32_t number = mesh_.face_textures.empty() ? 0 : mesh_.face_textures[face];
    if (number < 0 || static_cast<std::size_t>(number) >= textured_.size()) {
      builder_.note("PLY faces whose texture is not named in the file, plain colours used");
      return nullptr;
    }
    const std::optional<Material>& material = textured_[static_cast<std::size_t>(number)];
    return material ? &*material : nullptr;
  }

  std::uint16_t plain(std::size_t face, const std::array<std::uint64_t, 3>& corners) {
    Material material{.name = "default"};
    if (!mesh_.face_colors.empty()) {
      const glm::vec3& color = mesh_.face_colors[face];
      material.base_color = triangle_color(color, color, color);
    } else if (!mesh_.colors.empty()) {
      const auto color = [&](std::size_t k) { return mesh_.colors[mesh_.corners[corners[k]]]; };
      material.base_color = triangle_color(color(0), color(1), color(2));
    }
    return builder_.material(material);
  }

  // Of the polygon's points.
  void read_texcoords(std::uint64_t begin, std::uint64_t end) {
    uv_.clear();
    for (std::uint64_t i = begin; i < end; ++i) {
      const glm::vec2 uv =
          mesh_.corner_texcoords.empty() ? mesh_.texcoords[mesh_.corners[i]] : mesh_.corner_texcoords[i];
      uv_.emplace_back(uv.x, 1 - uv.y);  // upwards in the file
    }
    for (const Polygon::Crossing& crossing : polygon_.crossings)
      uv_.push_back(glm::mix(uv_[crossing.from], uv_[crossing.to], static_cast<float>(crossing.part)));
  }

  PlyMesh mesh_;
  SceneBuilder& builder_;
  ObjectMesh object_;
  std::vector<std::optional<Material>> textured_;  // of each texture file; nothing where it cannot be read
  Polygon polygon_;
  std::vector<glm::vec2> uv_;  // of its points
  std::vector<std::array<std::uint32_t, 3>> cut_;
};

}  // namespace

Status import_ply(std::span<const std::byte> bytes, const std::string& path, const InputFiles& files,
                  TextureImages& images, SceneBuilder& builder) {
  ZC_ASSIGN(PlyMesh mesh, read_ply(bytes, path));
  PlyImport import(std::move(mesh), path, builder);
  import.load_textures(path, files, images);
  return import.run();
}

}  // namespace zc
