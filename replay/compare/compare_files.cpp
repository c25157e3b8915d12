// SPDX-License-Identifier: Apache-2.0
#include "replay/compare/compare_files.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <span>
#include <system_error>

#include "base/file.h"

namespace zc {
namespace {

constexpr const char* kSheet = "contact_sheet.png";

std::string map_folder(const std::string& level) { return level + "_flip"; }

Status remove_earlier_pictures(const std::filesystem::path& out) {
  std::error_code code;
  std::vector<std::filesystem::path> folders;
  for (std::filesystem::directory_iterator at(out, code); !code && at != std::filesystem::directory_iterator();
       at.increment(code)) {
    const std::string name = at->path().filename().string();
    if (name == "source" || name == "finest" || name == map_folder("finest") || name.starts_with("level_") ||
        name.starts_with("tolerance_"))
      folders.push_back(at->path());
  }
  for (const std::filesystem::path& folder : folders) ZC_TRY(remove_written_pngs(folder));
  return remove_written_png(out / kSheet);
}

std::string compare_json(const CompareReport& report) {
  nlohmann::ordered_json json;
  json["device"] = report.device;
  json["frames"] = report.frames;
  json["blind_frames"] = report.blind_frames;
  json["source_complete"] = report.source_complete;
  json["pool_limited_by_device"] = report.limited_by_device;
  json["levels"] = nlohmann::ordered_json::array();
  for (const ComparedLevel& level : report.levels) {
    nlohmann::ordered_json row = {{"name", level.name}};
    if (level.depth) row.update({{"depth", *level.depth}, {"error_m_max", level.error_max_m}});
    if (level.tolerance) row["tolerance"] = *level.tolerance;
    row.update({{"mean_flip", level.mean_flip},
                {"max_flip", *std::ranges::max_element(level.flip)},
                {"triangles_per_frame", level.triangles / report.frames.size()},
                {"complete", !level.incomplete},
                {"flip", level.flip}});
    json["levels"].push_back(std::move(row));
  }
  return json.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

}  // namespace

Result<CompareFiles> CompareFiles::create(const std::filesystem::path& out) {
  ZC_TRY(make_folder(out));
  ZC_TRY(remove_earlier_pictures(out));
  return CompareFiles(out);
}

Status CompareFiles::add_level(const std::string& level, bool with_maps) const {
  ZC_TRY(make_folder(out_ / level));
  if (!with_maps) return {};
  return make_folder(out_ / map_folder(level));
}

Status CompareFiles::write_picture(const std::string& level, const std::string& frame, const Picture& picture) const {
  return write_png(out_ / level / (frame + ".png"), picture);
}

Status CompareFiles::write_map(const std::string& level, const std::string& frame, const Picture& map) const {
  return write_png(out_ / map_folder(level) / (frame + ".png"), map);
}

Status CompareFiles::write_sheet(const Picture& sheet) const { return write_png(out_ / kSheet, sheet); }

Status CompareFiles::write_report(const CompareReport& report) const {
  const std::string text = compare_json(report);
  return write_file(out_ / "compare.json", std::as_bytes(std::span(text)));
}

}  // namespace zc
