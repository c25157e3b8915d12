// SPDX-License-Identifier: GPL-3.0-or-later
// Formats that are not read, by their first bytes, their root or their files: a refusal names what a file is and what
// to do with it. Untrusted input. Thread-safe: no state.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace zc {

struct OtherFormat {
  const char* what;  // "an IFC model"
  const char* next;  // "export it as CityGML, CityJSON or glTF"
};

// Nothing for what is read, and for what is not known.
std::optional<OtherFormat> other_format(std::string_view bytes);

// By the files in a ZIP archive.
std::optional<OtherFormat> other_archive(std::span<const std::string> names);

}  // namespace zc
