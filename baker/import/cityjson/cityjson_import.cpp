// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/import/cityjson/cityjson_import.h"

#include <filesystem>
#include <istream>
#include <nlohmann/json.hpp>
#include <optional>

#include "baker/import/cityjson/cityjson_objects.h"
#include "baker/import/shared/json_text.h"

namespace zc {
namespace {

using nlohmann::json;

constexpr std::size_t kMaxLineBytes = std::size_t{1} << 28U;
constexpr const char* kBlank = " \t\r";
// What a file would have been told apart by, a pipe shows once.
constexpr const char* kOnlySequences =
    "does not begin with a line that is a CityJSON object: a pipe gives CityJSONSeq, any other format must be a file";

// Without its end, as std::getline() has it, but no more than one byte beyond kMaxLineBytes. False at the end.
bool next_line(std::istream& stream, std::string& line) {
  line.clear();
  try {
    std::streambuf& buffer = *stream.rdbuf();
    for (int c = buffer.sbumpc(); c != std::istream::traits_type::eof(); c = buffer.sbumpc()) {
      if (c == '\n') return true;
      line += static_cast<char>(c);
      if (line.size() > kMaxLineBytes) return true;
    }
  } catch (const std::ios_base::failure&) {  // the system refused to read
    stream.setstate(std::ios_base::badbit);
    return false;
  }
  return !line.empty();
}

Status check_header(const json& document, const CitySource& source) {
  const json* type = find_member(document, "type");
  if (type == nullptr || !type->is_string() || *type != "CityJSON")
    return source.error(
        "type is not 'CityJSON', expected CityJSON, glTF or a tileset.json; name the file of the model");
  const json* version = find_member(document, "version");
  if (version == nullptr || !version->is_string()) return source.error("version is missing or not text");
  const std::string& text = version->get_ref<const std::string&>();
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

Status import_cityjson(std::string_view text, const std::string& path, const InputFiles& files, TextureImages& images,
                       SceneBuilder& builder) {
  const CitySource source{path, text, 0, path, files};
  ZC_ASSIGN(const json document, parse_json(text, path));
  ZC_ASSIGN(const CityHeader header, read_header(document, source, builder));
  return add_city_objects(document, header, source, images, builder);
}

Status import_cityjson_seq(std::istream& stream, const std::string& path, const std::filesystem::path& model,
                           const InputFiles& files, TextureImages& images, SceneBuilder& builder) {
  std::string line;
  std::int64_t offset = 0;
  std::optional<CityHeader> header;
  const int begin = stream.peek();  // before a line without end is read
  if (begin != std::istream::traits_type::eof() &&
      std::string_view("{ \t\r\n\xEF").find(static_cast<char>(begin)) == std::string_view::npos)
    return Error{ErrorCode::kUnsupported, kOnlySequences, path, 0};
  while (next_line(stream, line)) {
    const std::int64_t line_offset = offset;
    if (line.size() > kMaxLineBytes)
      return Error{header ? ErrorCode::kFormat : ErrorCode::kUnsupported,
                   header ? "line is longer than 256 MiB" : kOnlySequences, path, line_offset};
    offset += static_cast<std::int64_t>(line.size()) + 1;
    std::string_view text = line;
    if (line_offset == 0 && text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);
    const std::size_t first = text.find_first_not_of(kBlank);
    if (first == std::string_view::npos) continue;
    if (!header && (text[first] != '{' || text[text.find_last_not_of(kBlank)] != '}'))
      return Error{ErrorCode::kUnsupported, kOnlySequences, path, line_offset};
    const CitySource source{path, text, line_offset, model, files};
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
  if (stream.bad()) return Error{ErrorCode::kIo, "cannot read", path, offset};
  if (!header) return Error{ErrorCode::kFormat, "is empty", path};
  return {};
}

}  // namespace zc
