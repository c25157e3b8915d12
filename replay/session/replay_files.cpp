// SPDX-License-Identifier: Apache-2.0
#include "replay/session/replay_files.h"

#include <algorithm>
#include <array>
#include <span>
#include <system_error>
#include <utility>

#include "base/file.h"
#include "replay/paths/spread_evenly.h"

namespace zc {
namespace {

constexpr std::size_t kSheetTiles = 12;
constexpr std::uint32_t kSheetColumns = 3;
constexpr std::uint32_t kTileWidth = 480;

constexpr std::array kDebugViews = {DebugView::kProvenance, DebugView::kBvh, DebugView::kNormals, DebugView::kDepth};
constexpr const char* kFrames = "frames";
constexpr const char* kLockName = ".zonecast.lock";
constexpr const char* kSheet = "contact_sheet.png";

const char* debug_name(DebugView view) {
  switch (view) {
    case DebugView::kProvenance:
      return "provenance";
    case DebugView::kBvh:
      return "bvh";
    case DebugView::kNormals:
      return "normals";
    case DebugView::kDepth:
      return "depth";
  }
  return "";
}

std::filesystem::path camera_folder(const std::filesystem::path& out, std::size_t camera) {
  return camera == 0 ? out : out / ("camera_" + std::to_string(camera));
}

Status remove_earlier_pictures(const std::filesystem::path& out) {
  std::error_code code;
  for (std::size_t c = 0; c == 0 || std::filesystem::is_directory(camera_folder(out, c), code); ++c) {
    const std::filesystem::path folder = camera_folder(out, c);
    ZC_TRY(remove_written_pngs(folder / kFrames));
    for (const DebugView view : kDebugViews) ZC_TRY(remove_written_pngs(folder / debug_name(view)));
    if (c > 0) std::filesystem::remove(folder, code);  // where nothing else is in it
  }
  return remove_written_png(out / kSheet);
}

Status make_folders(const ReplayOptions& options, std::size_t camera_count) {
  for (std::size_t c = 0; options.render && c < camera_count; ++c) {
    const std::filesystem::path folder = camera_folder(options.out, c);
    ZC_TRY(make_folder(folder / kFrames));
    for (const DebugView view : options.debug_views) ZC_TRY(make_folder(folder / debug_name(view)));
  }
  return {};
}

}  // namespace

Result<std::unique_ptr<ReplayFiles>> ReplayFiles::create(const ReplayOptions& options, std::size_t camera_count,
                                                         std::uint64_t frame_count) {
  ZC_TRY(make_folder(options.out));
  ZC_ASSIGN(std::optional<FolderLock> lock, FolderLock::take(options.out, kLockName));
  if (!lock)
    return Error{ErrorCode::kIo, "another replay is writing into this folder; wait for it or name another one",
                 options.out.string()};
  ZC_TRY(remove_earlier_pictures(options.out));
  ZC_TRY(make_folders(options, camera_count));
  ZC_ASSIGN(FrameLog log, FrameLog::create(options.out / "frames.csv", options.render));
  std::unique_ptr<ReplayFiles> files(new ReplayFiles(options, *std::move(lock), std::move(log)));
  if (options.trace) {
    ZC_ASSIGN(files->trace_, TraceFile::create(options.out / "trace.json", options.streamer.threads));
  }
  if (options.contact_sheet) files->sheet_frames_ = spread_evenly(frame_count, kSheetTiles);
  return files;
}

Status ReplayFiles::save_picture(const Picture& picture, std::size_t camera, const std::string& name) {
  ZC_TRY(write_png(camera_folder(options_.out, camera) / kFrames / (name + ".png"), picture));
  if (camera == 0 && std::ranges::binary_search(sheet_frames_, frames_done_))
    sheet_tiles_.push_back(scale_down(picture, kTileWidth));
  return {};
}

Status ReplayFiles::save_debug_view(const Picture& picture, std::size_t camera, DebugView view,
                                    const std::string& name) {
  return write_png(camera_folder(options_.out, camera) / debug_name(view) / (name + ".png"), picture);
}

Status ReplayFiles::end_frame(std::uint64_t frame, const FrameStatistics& paging, const FrameResult* drawn) {
  ++frames_done_;
  return log_.add(frame, paging, drawn);
}

Status ReplayFiles::close(std::string_view statistics) {
  ZC_TRY(log_.close());
  if (trace_) ZC_TRY(trace_->close());
  if (!sheet_tiles_.empty())
    ZC_TRY(write_png(options_.out / kSheet, make_contact_sheet(sheet_tiles_, kSheetColumns, kTileWidth)));
  return write_file(options_.out / "stats.json", std::as_bytes(std::span(statistics)));
}

}  // namespace zc
