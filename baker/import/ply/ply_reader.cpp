// SPDX-License-Identifier: GPL-3.0-or-later
// Greg Turk's PLY, 1994; texture coordinates as MeshLab writes them.
#include "baker/import/ply/ply_reader.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <optional>
#include <string_view>
#include <utility>

#include "baker/import/ply/ply_header.h"
#include "baker/import/shared/text_words.h"
#include "base/text.h"

namespace zc {
namespace {

constexpr std::uint64_t kMaxVertices = std::uint64_t{1} << 31U;
constexpr double kMaxTextures = 1 << 20;

using Row = std::vector<std::vector<double>>;  // per property, one number or a list

class PlyReader {
 public:
  PlyReader(std::string_view text, PlyHeader header, const std::string& path)
      : path_(path), text_(text), header_(std::move(header)), at_(header_.data_at), words_(text_.substr(at_), false) {}

  Result<PlyMesh> run() {
    mesh_.texture_files = header_.texture_files;
    for (const PlyElement& element : header_.elements) {
      ZC_TRY(check_count(element));
      Row row(element.properties.size());
      if (element.name == "vertex")
        ZC_TRY(read_vertices(element, row));
      else if (element.name == "face")
        ZC_TRY(read_faces(element, row));
      else if (element.name == "tristrips")
        return error("has triangle strips, which are not read; export it with faces");
      else if (!element.properties.empty())
        for (std::uint64_t i = 0; i < element.count; ++i) ZC_TRY(read_row(element, row));
    }
    for (const std::uint32_t corner : mesh_.corners)
      if (corner >= mesh_.positions.size())
        return error("a face names vertex " + std::to_string(corner) + ", expected one of the " +
                     std::to_string(mesh_.positions.size()) + " that there are; export it anew");
    return std::move(mesh_);
  }

 private:
  [[nodiscard]] Error error(std::string message, std::optional<std::size_t> at = std::nullopt) const {
    return {ErrorCode::kFormat, std::move(message), path_, at ? static_cast<std::int64_t>(*at) : -1};
  }
  [[nodiscard]] std::size_t at() const {
    return header_.form == PlyForm::kAscii ? header_.data_at + words_.offset() : at_;
  }
  [[nodiscard]] std::size_t left() const {
    return header_.form == PlyForm::kAscii ? text_.size() - header_.data_at - words_.at() : text_.size() - at_;
  }
  [[nodiscard]] Error cut_short() const {
    return error("ends early: the file is cut short; get it again", text_.size());
  }

  // Every value takes a byte, in text a character and what separates it from the next.
  [[nodiscard]] Status check_count(const PlyElement& element) const {
    std::uint64_t least = 0;
    for (const PlyProperty& property : element.properties)
      least +=
          header_.form == PlyForm::kAscii ? 2 : (property.count != nullptr ? property.count : property.type)->bytes;
    if (least > 0 && element.count > (left() + 1) / least)
      return error("declares " + std::to_string(element.count) + " of the element '" + printable(element.name, 40) +
                   "', which its " + std::to_string(text_.size()) +
                   " bytes cannot hold: it is damaged or cut short; get it again");
    return {};
  }

  Result<double> read_value(const PlyType& type) {
    if (header_.form == PlyForm::kAscii) {
      const std::string_view word = words_.word_anywhere();
      if (word.empty()) return cut_short();
      const std::optional<double> number = number_of(word);
      if (!number) return error("'" + printable(word, 40) + "' is no number; export it anew", at());
      return *number;
    }
    if (type.bytes > left()) return cut_short();
    std::array<unsigned char, 8> raw{};
    std::memcpy(raw.data(), text_.data() + at_, type.bytes);
    at_ += type.bytes;
    if (header_.form == PlyForm::kBig) std::reverse(raw.begin(), raw.begin() + type.bytes);
    std::uint64_t bits = 0;
    for (std::size_t i = 0; i < type.bytes; ++i) bits |= std::uint64_t{raw[i]} << (8 * i);
    if (type.kind == PlyKind::kFloat)
      return type.bytes == 8 ? std::bit_cast<double>(bits)
                             : static_cast<double>(std::bit_cast<float>(static_cast<std::uint32_t>(bits)));
    const std::uint64_t sign = std::uint64_t{1} << (8U * type.bytes - 1U);
    const double value = static_cast<double>(bits);
    return type.kind == PlyKind::kSigned && (bits & sign) != 0 ? value - 2.0 * static_cast<double>(sign) : value;
  }

  Status read_row(const PlyElement& element, Row& row) {
    for (std::size_t i = 0; i < row.size(); ++i) {
      const PlyProperty& property = element.properties[i];
      row[i].clear();
      double count = 1;
      if (property.count != nullptr) {
        ZC_ASSIGN(count, read_value(*property.count));
        const double least = header_.form == PlyForm::kAscii ? 2 : property.type->bytes;
        if (!(count >= 0) || count != std::floor(count) || count * least > static_cast<double>(left() + 1))
          return error(
              "has a list of more values than the rest of the file can hold: it is damaged or cut short; get "
              "it again",
              at());
      }
      for (double k = 0; k < count; ++k) {
        ZC_ASSIGN(const double value, read_value(*property.type));
        row[i].push_back(value);
      }
    }
    return {};
  }

  // Red, green and blue of a row, from 0 to 1.
  struct ColorPlace {
    std::size_t red = 0, green = 0, blue = 0;
    float scale = 1;
    [[nodiscard]] glm::vec3 of(const Row& row) const {
      return scale * glm::vec3(row[red].front(), row[green].front(), row[blue].front());
    }
  };
  static std::optional<ColorPlace> color_of(const PlyElement& element) {
    const auto red = element.find({"red", "diffuse_red", "r"});
    const auto green = element.find({"green", "diffuse_green", "g"});
    const auto blue = element.find({"blue", "diffuse_blue", "b"});
    if (!red || !green || !blue) return std::nullopt;
    const PlyType& type = *element.properties[*red].type;
    const float most = type.kind == PlyKind::kFloat ? 1.0F : type.bytes == 1 ? 255.0F : 65535.0F;
    return ColorPlace{*red, *green, *blue, 1 / most};
  }

  Status read_vertices(const PlyElement& element, Row& row) {
    const auto x = element.find({"x"});
    const auto y = element.find({"y"});
    const auto z = element.find({"z"});
    if (!x || !y || !z) return error("has vertices without x, y and z; export it anew");
    const auto color = color_of(element);
    const auto u = element.find({"texture_u", "u", "s"});
    const auto v = element.find({"texture_v", "v", "t"});
    if (element.count > kMaxVertices)
      return Error{ErrorCode::kUnsupported, "has more than 2^31 vertices; split it", path_};
    for (std::uint64_t i = 0; i < element.count; ++i) {
      ZC_TRY(read_row(element, row));
      mesh_.positions.emplace_back(row[*x].front(), row[*y].front(), row[*z].front());
      if (color) mesh_.colors.push_back(color->of(row));
      if (u && v) mesh_.texcoords.emplace_back(row[*u].front(), row[*v].front());
    }
    return {};
  }

  Status add_corner(double index) {
    if (!(index >= 0 && index < 0xFFFF'FFFFU) || index != std::floor(index))
      return error("a face names a vertex that cannot be, expected a number from 0; export it anew", at());
    mesh_.corners.push_back(static_cast<std::uint32_t>(index));
    return {};
  }

  Status read_faces(const PlyElement& element, Row& row) {
    const auto corners = element.find({"vertex_indices", "vertex_index"}, true);
    if (!corners) return error("has faces without the list vertex_indices; export it anew");
    const auto color = color_of(element);
    const auto uv = element.find({"texcoord"}, true);
    const auto texture = element.find({"texnumber"});
    for (std::uint64_t i = 0; i < element.count; ++i) {
      ZC_TRY(read_row(element, row));
      for (const double index : row[*corners]) ZC_TRY(add_corner(index));
      mesh_.face_ends.push_back(mesh_.corners.size());
      if (color) mesh_.face_colors.push_back(color->of(row));
      if (texture) {
        const double number = row[*texture].front();
        mesh_.face_textures.push_back(number >= 0 && number < kMaxTextures ? static_cast<std::int32_t>(number) : -1);
      }
      for (std::size_t k = 0; uv && k < row[*corners].size(); ++k)
        if (const std::vector<double>& list = row[*uv]; list.size() == 2 * row[*corners].size())
          mesh_.corner_texcoords.emplace_back(list[2 * k], list[2 * k + 1]);
        else
          mesh_.corner_texcoords.emplace_back(std::nanf(""));
    }
    return {};
  }

  const std::string& path_;
  std::string_view text_;
  const PlyHeader header_;
  std::size_t at_;   // of binary data
  TextWords words_;  // of text data
  PlyMesh mesh_;
};

}  // namespace

Result<PlyMesh> read_ply(std::span<const std::byte> bytes, const std::string& path) {
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  ZC_ASSIGN(PlyHeader header, read_ply_header(text, path));
  return PlyReader(text, std::move(header), path).run();
}

}  // namespace zc
