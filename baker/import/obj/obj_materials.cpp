// SPDX-License-Identifier: GPL-3.0-or-later
// tinyobjloader's code, compiled here alone. Of it only the reader of materials is called: that of geometry takes '1,5'
// for 1 and a word for 0, knows no place of a fault, and reads vertex colours only with the whole file in memory.
#include "baker/import/obj/obj_materials.h"

#define TINYOBJLOADER_IMPLEMENTATION
#define TINYOBJLOADER_USE_DOUBLE
#include <tiny_obj_loader.h>

#include <algorithm>
#include <cmath>
#include <sstream>

#include "baker/import/shared/scene_builder.h"
#include "baker/import/shared/text_words.h"
#include "baker/import/shared/uri.h"

namespace zc {
namespace {

constexpr std::uint64_t kMaxLibraryBytes = std::uint64_t{64} << 20U;
constexpr float kMatte = 0.9F;

float unit(double value) { return static_cast<float>(value > 0 ? std::min(value, 1.0) : 0.0); }  // no number: 0

std::string_view text_of(const std::vector<std::byte>& bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

bool has_line(std::string_view text, std::string_view key) {
  for (TextWords words(text, false); words.next_line();)
    if (words.word() == key) return true;
  return false;
}

// Of a highlight with the exponent Ns: alpha² = 2 / (Ns + 2) (Walter et al., "Microfacet Models for Refraction", 2007),
// of which roughness is the root, as in glTF.
float roughness_of(const tinyobj::material_t& source, std::string_view text) {
  if (has_line(text, "Pr")) return unit(source.roughness);
  const bool shines = source.specular[0] > 0 || source.specular[1] > 0 || source.specular[2] > 0;
  if (!shines || !has_line(text, "Ns")) return kMatte;
  return unit(std::pow(2 / (std::max(source.shininess, 0.0) + 2), 0.25));
}

}  // namespace

Result<std::filesystem::path> ObjMaterials::file_of(std::string name) const {
  std::replace(name.begin(), name.end(), '\\', '/');  // as Windows writes it
  return file_of_name(name, path_, folder_of(path_));
}

void ObjMaterials::add_library(std::string_view names) {
  if (add_file(std::string(names))) return;
  std::vector<std::string> missing = {std::string(names)};
  if (names.find(' ') != std::string_view::npos) {
    missing.clear();
    TextWords words(names, false);
    for (std::string_view name = words.word_anywhere(); !name.empty(); name = words.word_anywhere())
      if (!add_file(std::string(name))) missing.emplace_back(name);
  }
  missing_.insert(missing_.end(), missing.begin(), missing.end());
}

// False when it is not there.
bool ObjMaterials::add_file(const std::string& name) {
  const Result<std::filesystem::path> file = file_of(name);
  if (!seen_.insert(file.ok() ? file->string() : name).second) return true;
  if (!file.ok()) {
    outside_.push_back(name);
    return true;
  }
  Result<std::vector<std::byte>> bytes = files_.read(*file, kMaxLibraryBytes);
  if (!bytes.ok()) {
    seen_.erase(file->string());
    return false;
  }
  libraries_.push_back(std::move(*bytes));
  const std::string_view text = text_of(libraries_.back());
  std::string_view material;
  std::size_t begin = 0;
  const auto end_material = [&](std::size_t end) {
    if (begin > 0) written_.emplace(material, text.substr(begin, end - begin));
  };
  TextWords words(text, false);
  while (words.next_line()) {
    const std::size_t line = words.offset();
    if (words.word() != "newmtl") continue;
    end_material(line);
    material = words.rest();
    begin = words.at();
  }
  end_material(text.size());
  return true;
}

const ObjMaterial& ObjMaterials::find(std::string_view name) {
  if (const auto known = read_.find(name); known != read_.end()) return known->second;
  const auto written = written_.find(name);
  ObjMaterial material;
  if (written != written_.end()) material = read(written->second);
  if (written == written_.end() && !name.empty()) undefined_.emplace_back(name);
  material.material.name = name.empty() ? "default" : std::string(name);
  material.number = static_cast<std::uint32_t>(read_.size());
  return read_.emplace(name, std::move(material)).first->second;
}

ObjMaterial ObjMaterials::read(std::string_view text) const {
  std::istringstream stream{std::string(text)};
  std::map<std::string, int> names;
  std::vector<tinyobj::material_t> parsed;
  std::string warning;
  std::string failure;
  tinyobj::LoadMtl(&names, &parsed, &stream, &warning, &failure);
  ObjMaterial result;
  if (parsed.empty()) return result;
  const tinyobj::material_t& source = parsed.front();
  Material& material = result.material;
  result.has_color = has_line(text, "Kd");
  if (result.has_color)
    for (int c = 0; c < 3; ++c) material.base_color[c] = srgb_to_linear(unit(source.diffuse[c]));
  material.roughness = roughness_of(source, text);
  material.metallic = unit(source.metallic);

  const tinyobj::texture_option_t& option =
      source.diffuse_texname.empty() ? source.alpha_texopt : source.diffuse_texopt;
  const TextureWrap wrap = option.clamp ? TextureWrap::kClamp : TextureWrap::kRepeat;
  result.uv_scale = {option.scale[0], option.scale[1]};
  result.uv_offset = {option.origin_offset[0], option.origin_offset[1]};
  if (const std::string& name = source.diffuse_texname; !name.empty()) {
    // Many programs write a black Kd beside a texture, which is then meant to be the colour.
    if (!result.has_color || material.base_color == glm::vec3(0)) material.base_color = glm::vec3(1);
    if (const auto image = images_.of_file(file_of(name), name, files_)) {
      material.texture =
          SurfaceTexture{.image = image->index, .wrap_u = wrap, .wrap_v = wrap, .factor = material.base_color};
      material.base_color *= image->mean;
    }
  }
  const double dissolve = unit(source.dissolve);
  if (const std::string& name = source.alpha_texname; !name.empty())
    result.coverage = Coverage{images_.coverage_of_file(file_of(name), name, files_), wrap, wrap, dissolve};
  else if (dissolve < 1)
    result.coverage = Coverage{nullptr, wrap, wrap, dissolve};
  return result;
}

void ObjMaterials::report() const {
  builder_.note_files("material libraries (.mtl) that are not there, grey used", missing_);
  builder_.note_files("material libraries (.mtl) that lie outside the folder of their input, not read, grey used",
                      outside_);
  builder_.note_files("OBJ materials that no library defines, grey used", undefined_);
}

}  // namespace zc
