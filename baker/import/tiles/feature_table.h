// SPDX-License-Identifier: GPL-3.0-or-later
// The feature table of a b3dm or i3dm: values by name, in JSON or as bytes behind it. Source: OGC 22-025r4, section 10
// (feature table). Borrows the tile's bytes. Untrusted input: every range is checked. Thread-safe for const use.
#pragma once

#include <cstdint>
#include <cstring>
#include <glm/vec3.hpp>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>

#include "base/result.h"

namespace zc {

template <class T>
T load_number(std::span<const std::byte> bytes, std::size_t at) {
  T value{};
  std::memcpy(&value, bytes.data() + at, sizeof value);
  return value;
}

class FeatureTable {
 public:
  // `at`: of the JSON in the file at `path`.
  static Result<FeatureTable> read(std::span<const std::byte> json, std::span<const std::byte> binary,
                                   const std::string& path, std::size_t at);

  // Nothing where there is no such value.
  [[nodiscard]] Result<std::optional<glm::dvec3>> vector(const char* name) const;
  [[nodiscard]] Result<std::optional<std::uint64_t>> number(const char* name) const;
  // `count` elements of so many bytes.
  [[nodiscard]] Result<std::optional<std::span<const std::byte>>> elements(const char* name, std::uint64_t count,
                                                                           std::size_t element_bytes) const;
  [[nodiscard]] bool is_true(const char* name) const;
  [[nodiscard]] Error error(std::string message) const {
    return {ErrorCode::kFormat, std::move(message), path_, static_cast<std::int64_t>(at_)};
  }

 private:
  FeatureTable(nlohmann::json values, std::span<const std::byte> binary, std::string path, std::size_t at)
      : values_(std::move(values)), binary_(binary), path_(std::move(path)), at_(at) {}
  [[nodiscard]] Result<std::span<const std::byte>> bytes_at(const char* name, std::uint64_t offset,
                                                            std::uint64_t bytes) const;

  nlohmann::json values_;
  std::span<const std::byte> binary_;
  std::string path_;
  std::size_t at_;
};

}  // namespace zc
