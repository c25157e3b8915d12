// SPDX-License-Identifier: Apache-2.0
// What `compare` compares: the full detail, stored levels of proxies, and what a replay pages at some tolerances. Pure.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "replay/compare/compare.h"
#include "replay/compare/compare_sheet.h"
#include "streamer/world_format/world_index.h"

namespace zc {

struct CompareLevel {
  ComparedLevel row;
  double tolerance = 0;           // that it is paged at
  bool is_source = false;         // the full detail, which the others are compared with
  std::optional<WorldIndex> cut;  // of a stored level: the world down to its depth
  SheetColumn column;
};

// The source first, then as run_compare() names them.
std::vector<CompareLevel> levels_of(const WorldIndex& index, const std::vector<double>& tolerances);

}  // namespace zc
