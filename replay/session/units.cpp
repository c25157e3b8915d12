// SPDX-License-Identifier: Apache-2.0
#include "replay/session/units.h"

#include <array>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <optional>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

namespace zc {
namespace {

using Unit = std::pair<std::string_view, double>;

constexpr std::array<Unit, 9> kByteUnits = {{{"", 1},
                                             {"B", 1},
                                             {"kB", 1e3},
                                             {"MB", 1e6},
                                             {"GB", 1e9},
                                             {"KiB", 1024.0},
                                             {"MiB", 1048576.0},
                                             {"GiB", 1073741824.0},
                                             {"KB", 1e3}}};
constexpr std::array<Unit, 3> kTimeUnits = {{{"s", 1}, {"ms", 1e-3}, {"us", 1e-6}}};

Error bad(const std::string& text, const char* example) {
  return {ErrorCode::kArgument, "'" + text + "' is not a quantity such as " + example};
}

// A non-negative number and its unit.
std::optional<double> parse_quantity(std::string_view text, std::span<const Unit> units) {
  double number = 0;
  const auto [rest, failure] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (failure != std::errc{} || !std::isfinite(number) || number < 0) return std::nullopt;
  std::string_view unit(rest, static_cast<std::size_t>(text.data() + text.size() - rest));
  if (unit.starts_with(' ')) unit.remove_prefix(1);
  for (const auto& [name, factor] : units) {
    if (unit == name) return number * factor;
  }
  return std::nullopt;
}

// Whole numbers separated by `separator`, each at most 2^53.
std::optional<std::vector<std::uint64_t>> parse_list(std::string_view text, char separator) {
  std::vector<std::uint64_t> values;
  const char* at = text.data();
  const char* const end = at + text.size();
  while (true) {
    std::uint64_t value = 0;
    const auto [rest, failure] = std::from_chars(at, end, value);
    if (failure != std::errc{} || value > (1ULL << 53U)) return std::nullopt;
    values.push_back(value);
    if (rest == end) return values;
    if (*rest != separator) return std::nullopt;
    at = rest + 1;
  }
}

}  // namespace

Result<std::uint64_t> parse_bytes(const std::string& text) {
  const auto value = parse_quantity(text, kByteUnits);
  if (!value || *value > 9e15) return bad(text, "64MiB");
  return static_cast<std::uint64_t>(*value);
}

Result<double> parse_seconds(const std::string& text) {
  const auto value = parse_quantity(text, kTimeUnits);
  if (!value) return bad(text, "50ms");
  return *value;
}

Result<double> parse_bytes_per_second(const std::string& text) {
  if (!text.ends_with("/s")) return bad(text, "20MB/s");
  const auto value = parse_quantity(std::string_view(text).substr(0, text.size() - 2), kByteUnits);
  if (!value || *value <= 0) return bad(text, "20MB/s");
  return *value;
}

std::string format_bytes(std::uint64_t bytes) {
  constexpr std::array<const char*, 4> names = {"B", "KiB", "MiB", "GiB"};
  double value = static_cast<double>(bytes);
  std::size_t unit = 0;
  while (value >= 1024 && unit + 1 < names.size()) {
    value /= 1024;
    ++unit;
  }
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), unit == 0 ? "%.0f %s" : "%.1f %s", value, names[unit]);
  return text.data();
}

Result<FrameRange> parse_frames(const std::string& text) {
  if (text == "all") return FrameRange{};
  const auto values = parse_list(text, ':');
  if (!values || values->size() < 2 || values->size() > 3 || (*values)[1] <= (*values)[0] ||
      (values->size() == 3 && (*values)[2] == 0))
    return Error{ErrorCode::kArgument, "'" + text + "' is not a frame range A:B or A:B:STEP with A < B, or all"};
  return FrameRange{(*values)[0], (*values)[1], values->size() == 3 ? (*values)[2] : 1};
}

Result<PictureSize> parse_size(const std::string& text) {
  const auto values = parse_list(text, 'x');
  if (!values || values->size() != 2 || (*values)[0] < 8 || (*values)[1] < 8 || (*values)[0] > 4096 ||
      (*values)[1] > 4096)
    return Error{ErrorCode::kArgument, "'" + text + "' is not a picture size such as 1280x720 (8 to 4096 a side)"};
  return PictureSize{static_cast<std::uint32_t>((*values)[0]), static_cast<std::uint32_t>((*values)[1])};
}

Result<SunAngles> parse_sun(const std::string& text) {
  const auto number = [](std::string_view part, float& value) {
    const auto [end, failure] = std::from_chars(part.data(), part.data() + part.size(), value);
    return failure == std::errc() && end == part.data() + part.size() && std::isfinite(value);
  };
  SunAngles sun;
  const std::string_view view = text;
  const std::size_t comma = view.find(',');
  if (comma == std::string_view::npos || !number(view.substr(0, comma), sun.azimuth_deg) ||
      !number(view.substr(comma + 1), sun.elevation_deg) || std::abs(sun.azimuth_deg) > 360 ||
      std::abs(sun.elevation_deg) > 90)
    return Error{ErrorCode::kArgument, "'" + text + "' is not a sun direction such as 145,38 (azimuth, elevation)"};
  return sun;
}

}  // namespace zc
