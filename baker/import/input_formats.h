// SPDX-License-Identifier: GPL-3.0-or-later
// What an input is, by its content; by its name only whether a folder or an archive is worth searching for it.
// Untrusted input. Thread-safe: no state.
#pragma once

#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <istream>
#include <span>
#include <streambuf>
#include <string_view>

namespace zc {

inline constexpr const char* kReadFormats =
    "glTF, GLB, CityJSON, CityJSONSeq, CityGML, OBJ, PLY or 3D Tiles (tileset.json, .3tz, b3dm, i3dm, cmpt), or one of "
    "them as .gz or .zip";

enum class InputFormat { kUnknown, kGlb, kXml, kJson, kObj, kPly };
// By the first bytes, of which there is one at least.
InputFormat format_of(std::span<const std::byte> begin);

// A sequence of documents: the first line is closed and another object begins after it, which one JSON document never
// does. Reads no further than that.
bool is_sequence(std::istream& stream, const std::filesystem::path& path);

// Whether the first line of a sequence is that of CityJSONSeq.
bool begins_with_city_model(std::istream& stream);

// glTF may have no asset: version 1.0 did not ask for one.
bool is_gltf(std::string_view json);

// Whether JSON or XML is a city model, and no other document that lies beside one.
bool is_city_model(InputFormat format, std::string_view text);

// Whether what a folder or an archive calls so may be a model: .gml, .json, ..., and with .gz behind it. Hidden files
// and folders are none.
bool has_model_name(const std::filesystem::path& name);

// Bytes in memory as a stream. Borrows them.
class MemoryStream : private std::streambuf, public std::istream {
 public:
  explicit MemoryStream(std::span<const std::byte> bytes) : std::istream(static_cast<std::streambuf*>(this)) {
    char* begin = const_cast<char*>(reinterpret_cast<const char*>(bytes.data()));  // which is not written to
    setg(begin, begin, begin + bytes.size());
  }

 private:
  std::streampos seekpos(std::streampos place, std::ios_base::openmode /*which*/) override {
    setg(eback(), eback() + std::min<std::streamoff>(place, egptr() - eback()), egptr());
    return gptr() - eback();
  }
};

}  // namespace zc
