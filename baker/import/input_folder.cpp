// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/import/input_folder.h"

#include <algorithm>
#include <system_error>

#include "baker/import/input_formats.h"
#include "base/text.h"

namespace zc {
namespace {

constexpr const char* kTilesetName = "tileset.json";
constexpr const char* kWorldName = "world.zcw";  // beside it is a tileset.json, of what was baked before

}  // namespace

Result<std::vector<std::filesystem::path>> models_in_folder(const std::filesystem::path& folder) {
  namespace fs = std::filesystem;
  std::error_code failure;
  if (fs::exists(folder / kTilesetName, failure)) return std::vector<fs::path>{folder / kTilesetName};
  std::vector<fs::path> models;
  fs::path place = folder;
  fs::recursive_directory_iterator entry(folder, failure);
  for (; !failure && entry != fs::recursive_directory_iterator(); entry.increment(failure)) {
    const fs::path& path = entry->path();
    std::error_code none;
    if (entry->is_directory(none)) {
      place = path;
      const bool is_hidden = path.filename().string().starts_with('.') || path.filename() == "__MACOSX";
      const bool is_world = fs::exists(path / kWorldName, none);
      const bool is_tileset = fs::exists(path / kTilesetName, none);
      if (is_tileset && !is_world && !is_hidden) models.push_back(path / kTilesetName);
      if (is_hidden || is_world || is_tileset) entry.disable_recursion_pending();
    } else if (entry->is_regular_file(none) &&
               (has_model_name(path.filename()) || lower(path.extension().string()) == ".zip")) {
      models.push_back(path);
    }
  }
  if (failure) return Error{ErrorCode::kIo, "cannot read the folder: " + failure.message(), place.string()};
  std::sort(models.begin(), models.end(),
            [](const fs::path& a, const fs::path& b) { return a.generic_string() < b.generic_string(); });
  return models;
}

}  // namespace zc
