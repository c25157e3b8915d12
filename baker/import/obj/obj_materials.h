// SPDX-License-Identifier: GPL-3.0-or-later
// The materials of an OBJ file, of the libraries (MTL) that it names. tinyobjloader reads one material at a time, when
// it is first used, so that a library takes no more memory than its text. Owns the texts. Untrusted input: libraries
// and images lie in the folder of the input or below. Not thread-safe.
#pragma once

#include <cstddef>
#include <filesystem>
#include <glm/vec2.hpp>
#include <list>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "baker/import/shared/input_files.h"
#include "baker/import/shared/opaque_part.h"
#include "baker/import/shared/texture_images.h"
#include "baker/scene/scene.h"

namespace zc {

struct ObjMaterial {
  Material material;
  bool has_color = false;            // Kd is written; else the vertices' colours are the surface's
  std::optional<Coverage> coverage;  // of what is transparent
  glm::vec2 uv_scale{1};
  glm::vec2 uv_offset{0};
  std::uint32_t number = 0;  // in the order of their use
};

class ObjMaterials {
 public:
  ObjMaterials(std::string path, const InputFiles& files, TextureImages& images, SceneBuilder& builder)
      : path_(std::move(path)), files_(files), images_(images), builder_(builder) {}

  // The file or the files that a line "mtllib" names. What is not there or lies outside is noted.
  void add_library(std::string_view names);
  // Grey where nothing is so called. Of two with a name, the first.
  const ObjMaterial& find(std::string_view name);
  void report() const;

 private:
  bool add_file(const std::string& name);
  [[nodiscard]] ObjMaterial read(std::string_view text) const;
  [[nodiscard]] Result<std::filesystem::path> file_of(std::string name) const;

  std::string path_;  // of the OBJ file
  const InputFiles& files_;
  TextureImages& images_;
  SceneBuilder& builder_;
  std::set<std::string> seen_;                                         // libraries
  std::list<std::vector<std::byte>> libraries_;                        // whose texts these are:
  std::map<std::string_view, std::string_view, std::less<>> written_;  // by name
  std::map<std::string, ObjMaterial, std::less<>> read_;
  std::vector<std::string> missing_;
  std::vector<std::string> outside_;
  std::vector<std::string> undefined_;
};

}  // namespace zc
