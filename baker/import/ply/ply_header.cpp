// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/import/ply/ply_header.h"

#include <algorithm>
#include <array>
#include <utility>

#include "baker/import/shared/text_words.h"
#include "base/text.h"

namespace zc {
namespace {

constexpr std::array<PlyType, 8> kTypes = {{{"char", "int8", PlyKind::kSigned, 1},
                                            {"uchar", "uint8", PlyKind::kUnsigned, 1},
                                            {"short", "int16", PlyKind::kSigned, 2},
                                            {"ushort", "uint16", PlyKind::kUnsigned, 2},
                                            {"int", "int32", PlyKind::kSigned, 4},
                                            {"uint", "uint32", PlyKind::kUnsigned, 4},
                                            {"float", "float32", PlyKind::kFloat, 4},
                                            {"double", "float64", PlyKind::kFloat, 8}}};

const PlyType* type_of(std::string_view name) {
  const auto* found =
      std::find_if(kTypes.begin(), kTypes.end(), [&](const PlyType& t) { return name == t.name || name == t.alias; });
  return found == kTypes.end() ? nullptr : found;
}

}  // namespace

Result<PlyHeader> read_ply_header(std::string_view text, const std::string& path) {
  PlyHeader header;
  TextWords words(text, false);
  const auto header_error = [&](const std::string& message) {
    return Error{ErrorCode::kFormat, message, path, static_cast<std::int64_t>(words.offset())};
  };
  words.next_line();
  words.word();  // ply
  const std::string_view line_end = text.substr(words.at(), 2) == "\r\n" ? "\r\n" : text.substr(words.at(), 1);
  bool has_format = false;
  while (words.next_line()) {
    const std::string_view key = words.word();
    if (key == "end_header") {
      header.data_at = std::min(words.at() + line_end.size(), text.size());
      if (!has_format) return header_error("has a header without a format; export it anew");
      return header;
    }
    if (key == "comment") {
      if (words.word() == "TextureFile") header.texture_files.emplace_back(words.rest());
    } else if (key == "format") {
      const std::string_view name = words.word();
      if (name != "ascii" && name != "binary_little_endian" && name != "binary_big_endian")
        return header_error("has the format '" + printable(name, 40) +
                            "', expected ascii, binary_little_endian or binary_big_endian; export it anew");
      header.form = name == "ascii" ? PlyForm::kAscii : name == "binary_big_endian" ? PlyForm::kBig : PlyForm::kLittle;
      has_format = true;
    } else if (key == "element") {
      PlyElement element;
      element.name = words.word();
      const auto count = integer_of(words.word());
      if (element.name.empty() || !count || *count < 0)
        return header_error("has an element without a name and a count; export it anew");
      if (std::any_of(header.elements.begin(), header.elements.end(),
                      [&](const PlyElement& e) { return e.name == element.name; }))
        return header_error("has the element '" + printable(element.name, 40) + "' twice; export it anew");
      element.count = static_cast<std::uint64_t>(*count);
      header.elements.push_back(std::move(element));
    } else if (key == "property") {
      PlyProperty property;
      std::string_view type = words.word();
      const bool is_list = type == "list";
      if (is_list) {
        property.count = type_of(words.word());
        type = words.word();
      }
      property.type = type_of(type);
      property.name = words.word();
      if (header.elements.empty() || property.type == nullptr || property.name.empty() ||
          (is_list && (property.count == nullptr || property.count->kind == PlyKind::kFloat)))
        return header_error(
            "has a property that is none of an element, or without a known type and a name; export "
            "it anew");
      header.elements.back().properties.push_back(std::move(property));
    }
  }
  return header_error("has no end_header: the file is cut short; get it again");
}

}  // namespace zc
