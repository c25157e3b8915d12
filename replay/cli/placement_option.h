// SPDX-License-Identifier: Apache-2.0
// Where the inputs of a bake stand: --scale, --up, --offset and --crs, each given once for all inputs or once for each.
#pragma once

#include <CLI/CLI.hpp>
#include <array>
#include <charconv>
#include <cmath>
#include <string>
#include <string_view>
#include <vector>

#include "baker/import/shared/world_placement.h"
#include "base/result.h"
#include "base/text.h"

namespace zc {

struct PlacementOption {
  std::vector<std::string> scales, ups, offsets, systems;  // as given
};

inline void add_placement_options(CLI::App& command, PlacementOption& asked) {
  const auto add = [&](const char* name, std::vector<std::string>& values, const char* text) {
    command.add_option(name, values, text)
        ->allow_extra_args(false)
        ->group("Where inputs stand (each once for all inputs, or once for each)");
  };
  add("--scale", asked.scales, "Metres that one unit of the input is: 0.001 for millimetres");
  add("--up", asked.ups, "Axis that points up in the input, x|y|z, or auto: as the format has it");
  add("--offset", asked.offsets, "Metres east, north and up to move the input by, after scale and turn: X,Y,Z");
  add("--crs", asked.systems,
      "Reference system of the input: EPSG:N, local (none), or auto: as the file names it. Inputs of several systems "
      "are "
      "moved to the first one");
}

namespace placement_option {

// "1,2,3": finite numbers and nothing else.
template <std::size_t N>
bool read_numbers(std::string_view text, std::array<double, N>& numbers) {
  for (std::size_t i = 0; i < N; ++i) {
    if (i > 0) {
      if (!text.starts_with(',')) return false;
      text.remove_prefix(1);
    }
    const auto [end, failure] = std::from_chars(text.data(), text.data() + text.size(), numbers[i]);
    if (failure != std::errc() || !std::isfinite(numbers[i])) return false;
    text.remove_prefix(static_cast<std::size_t>(end - text.data()));
  }
  return text.empty();
}

inline Error wrong(const char* option, const std::string& expected, const std::string& value) {
  return {ErrorCode::kArgument, std::string(option) + " is " + expected + ", not '" + printable(value, 80) + "'"};
}

inline Status read_scale(const std::string& text, Placement& placement) {
  std::array<double, 1> scale{};
  if (!read_numbers(text, scale) || !(scale[0] >= 1e-9 && scale[0] <= 1e9))
    return wrong("--scale", "a number from 1e-9 to 1e9", text);
  placement.scale = scale[0];
  return {};
}

inline Status read_up(const std::string& text, Placement& placement) {
  if (text == "x") placement.up = UpAxis::kX;
  if (text == "y") placement.up = UpAxis::kY;
  if (text == "z") placement.up = UpAxis::kZ;
  return placement.up || text == "auto" ? Status() : wrong("--up", "x, y, z or auto", text);
}

inline Status read_offset(const std::string& text, Placement& placement) {
  std::array<double, 3> offset{};
  if (!read_numbers(text, offset)) return wrong("--offset", "three numbers, as in 690000,5336000,412", text);
  placement.offset_m = {offset[0], offset[1], offset[2]};
  return {};
}

inline Status read_system(const std::string& text, Placement& placement) {
  if (text == "auto") return {};
  placement.crs = text == "local" ? "" : text;
  if (text == "local" || ReferenceSystem(text).is_placed()) return {};
  return wrong("--crs", "EPSG:N with a code that PROJ knows, local or auto", text);
}

}  // namespace placement_option

// One for each input; none when nothing was asked.
inline Result<std::vector<Placement>> placements_of(const PlacementOption& asked, std::size_t inputs) {
  using Read = Status (*)(const std::string&, Placement&);
  struct Column {
    const char* name;
    const std::vector<std::string>& values;
    Read read;
  };
  const std::array<Column, 4> columns = {{{"--scale", asked.scales, placement_option::read_scale},
                                          {"--up", asked.ups, placement_option::read_up},
                                          {"--offset", asked.offsets, placement_option::read_offset},
                                          {"--crs", asked.systems, placement_option::read_system}}};
  std::vector<Placement> placements;
  for (const Column& column : columns) {
    if (column.values.empty()) continue;
    if (column.values.size() != 1 && column.values.size() != inputs)
      return Error{ErrorCode::kArgument,
                   std::string(column.name) + " is given " + std::to_string(column.values.size()) + " times for " +
                       std::to_string(inputs) + " inputs: give it once for all of them, or once for each"};
    placements.resize(inputs);
    for (std::size_t i = 0; i < inputs; ++i)
      ZC_TRY(column.read(column.values[column.values.size() == 1 ? 0 : i], placements[i]));
  }
  return placements;
}

}  // namespace zc
