// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/import/input_formats.h"

#include <algorithm>
#include <array>
#include <string>

#include "baker/import/citygml/citygml_import.h"
#include "baker/import/obj/obj_import.h"
#include "baker/import/shared/json_text.h"
#include "baker/import/tiles/tileset_file.h"
#include "base/text.h"

namespace zc {
namespace {

constexpr const char* kBlank = " \t\r\n";
constexpr std::array<std::string_view, 9> kModelNames = {".gml",  ".xml", ".citygml", ".json", ".jsonl",
                                                         ".gltf", ".glb", ".obj",     ".ply"};

}  // namespace

InputFormat format_of(std::span<const std::byte> begin) {
  std::string_view text(reinterpret_cast<const char*>(begin.data()), begin.size());
  if (text.starts_with("glTF")) return InputFormat::kGlb;
  if (text.starts_with("\xFF\xFE") || text.starts_with("\xFE\xFF"))
    return InputFormat::kXml;  // UTF-16, which JSON is not
  if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);
  const std::size_t start = text.find_first_not_of(kBlank);
  if (start == std::string_view::npos) return InputFormat::kUnknown;
  if (text[start] == '<') return InputFormat::kXml;
  if (text[start] == '{') return InputFormat::kJson;
  if (text.starts_with("ply\n") || text.starts_with("ply\r")) return InputFormat::kPly;
  return is_obj(text) ? InputFormat::kObj : InputFormat::kUnknown;
}

bool is_sequence(std::istream& stream, const std::filesystem::path& path) {
  char last = 0;
  for (char c = 0; stream.get(c) && c != '\n';)
    if (std::string_view(kBlank).find(c) == std::string_view::npos) last = c;
  if (last != '}') return false;
  for (char c = 0; stream.get(c);)
    if (std::string_view(kBlank).find(c) == std::string_view::npos) return c == '{';
  // A header and nothing else.
  return path.extension() == ".jsonl" || path.string().ends_with(".jsonl.gz");
}

bool begins_with_city_model(std::istream& stream) {
  constexpr std::size_t kLongestHeader = std::size_t{1} << 24U;
  std::string line;
  for (char c = 0; line.size() < kLongestHeader && stream.get(c) && c != '\n';) line += c;
  return has_top_level_key(line, "CityObjects");
}

bool is_gltf(std::string_view json) {
  return (has_top_level_key(json, "asset") || has_top_level_key(json, "meshes")) &&
         !has_top_level_key(json, "CityObjects");
}

bool is_city_model(InputFormat format, std::string_view text) {
  if (format == InputFormat::kGlb || format == InputFormat::kObj || format == InputFormat::kPly) return true;
  if (format == InputFormat::kXml) {
    const std::string root = root_of_xml(text);
    return root == "CityModel" || root.empty();
  }
  return format == InputFormat::kJson && (has_top_level_key(text, "CityObjects") || is_tileset(text) || is_gltf(text));
}

bool has_model_name(const std::filesystem::path& name) {
  for (const std::filesystem::path& part : name)
    if (part.native().starts_with('.') || part == "__MACOSX") return false;
  std::string text = lower(name.string());
  if (text.ends_with(".gz")) text.resize(text.size() - 3);
  return std::any_of(kModelNames.begin(), kModelNames.end(), [&](std::string_view end) { return text.ends_with(end); });
}

}  // namespace zc
