// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/import/cityjson_import.h"

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <optional>

#include "baker/import/cityjson_objects.h"
#include "baker/import/json_text.h"

namespace zc {
namespace {

using nlohmann::json;

Status check_header(const json& document, const CitySource& source) {
  const json* type = find_member(document, "type");
  if (type == nullptr || !type->is_string() || *type != "CityJSON") return source.error("type is not 'CityJSON'");
  const json* version = find_member(document, "version");
  const std::string text = version != nullptr && version->is_string() ? version->get<std::string>() : "";
  const auto is = [&](std::string_view wanted) {
    return text == wanted || (text.starts_with(wanted) && text[wanted.size()] == '.');
  };
  if (!is("1.1") && !is("2.0"))
    return Error{ErrorCode::kUnsupported, "CityJSON version '" + one_line(text) + "', only 1.1 and 2.0 are read",
                 source.path, source.base_offset};
  return {};
}

Result<std::string> crs_of(const json& document, const CitySource& source) {
  const json* metadata = find_member(document, "metadata");
  const json* crs = metadata != nullptr ? find_member(*metadata, "referenceSystem") : nullptr;
  if (crs == nullptr) return std::string();
  if (!crs->is_string()) return source.error("metadata.referenceSystem is not text");
  return crs->get<std::string>();
}

// Templates keep their own JSON, vertices and appearance: features of later lines refer to them.
Status read_templates(const json& document, const CitySource& source, CityHeader& header) {
  const json* block = find_member(document, "geometry-templates");
  if (block == nullptr) return {};
  const json* templates = find_member(*block, "templates");
  const json* vertices = find_member(*block, "vertices-templates");
  if (templates == nullptr || vertices == nullptr || !templates->is_array())
    return source.error("geometry-templates lacks templates or vertices-templates");
  ZC_ASSIGN(header.template_vertices, read_city_vertices(*vertices, {}, source));
  header.templates.assign(templates->begin(), templates->end());
  return {};
}

Result<CityHeader> read_header(const json& document, const CitySource& source, SceneBuilder& builder) {
  ZC_TRY(check_header(document, source));
  CityHeader header;
  ZC_ASSIGN(header.transform, read_city_transform(document, source));
  ZC_ASSIGN(header.appearance, read_city_appearance(document, source));
  ZC_TRY(read_templates(document, source, header));
  ZC_ASSIGN(const std::string crs, crs_of(document, source));
  ZC_TRY(builder.set_crs(crs, source.path));
  return header;
}

}  // namespace

Status import_cityjson(std::string_view text, const std::string& path, TextureImages& images, SceneBuilder& builder) {
  const CitySource source{path, text, 0};
  ZC_ASSIGN(const json document, parse_json(text, path));
  ZC_ASSIGN(const CityHeader header, read_header(document, source, builder));
  return add_city_objects(document, header, source, images, builder);
}

Status import_cityjson_seq(const std::string& path, TextureImages& images, SceneBuilder& builder) {
  std::ifstream file(path, std::ios::binary);
  if (!file) return Error{ErrorCode::kIo, std::string("cannot open: ") + std::strerror(errno), path};
  std::string line;
  std::int64_t offset = 0;
  std::optional<CityHeader> header;
  while (std::getline(file, line)) {
    const std::int64_t line_offset = offset;
    offset += static_cast<std::int64_t>(line.size()) + 1;
    std::string_view text = line;
    if (line_offset == 0 && text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);
    if (text.find_first_not_of(" \t\r") == std::string_view::npos) continue;
    const CitySource source{path, text, line_offset};
    ZC_ASSIGN(const json document, parse_json(text, path, line_offset));
    if (!header) {
      ZC_ASSIGN(header, read_header(document, source, builder));
    } else {
      const json* type = find_member(document, "type");
      if (type == nullptr || !type->is_string() || *type != "CityJSONFeature")
        return source.error("line is no CityJSONFeature");
    }
    ZC_TRY(add_city_objects(document, *header, source, images, builder));
  }
  if (file.bad()) return Error{ErrorCode::kIo, "cannot read", path, offset};
  if (!header) return Error{ErrorCode::kFormat, "file is empty", path};
  return {};
}

}  // namespace zc
