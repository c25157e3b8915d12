// SPDX-License-Identifier: GPL-3.0-or-later
// What the header of a PLY file declares. Untrusted input: counts are as they are written. Thread-safe: no state.
#pragma once

#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"

namespace zc {

enum class PlyForm { kAscii, kLittle, kBig };
enum class PlyKind { kSigned, kUnsigned, kFloat };

struct PlyType {
  const char* name;
  const char* alias;
  PlyKind kind;
  std::uint8_t bytes;
};

struct PlyProperty {
  std::string name;
  const PlyType* type = nullptr;
  const PlyType* count = nullptr;  // of a list, an integer
};

struct PlyElement {
  std::string name;
  std::uint64_t count = 0;
  std::vector<PlyProperty> properties;

  // Where the first property of these names stands; nothing when there is none.
  [[nodiscard]] std::optional<std::size_t> find(std::initializer_list<const char*> names, bool list = false) const {
    for (const char* wanted : names)
      for (std::size_t i = 0; i < properties.size(); ++i)
        if (properties[i].name == wanted && (properties[i].count != nullptr) == list) return i;
    return std::nullopt;
  }
};

struct PlyHeader {
  PlyForm form = PlyForm::kAscii;
  std::vector<PlyElement> elements;  // of different names
  std::vector<std::string> texture_files;
  std::size_t data_at = 0;  // behind the header
};

Result<PlyHeader> read_ply_header(std::string_view text, const std::string& path);

}  // namespace zc
