// SPDX-License-Identifier: Apache-2.0
// What a replay writes into its folder: frames.csv, trace.json, a picture a frame, camera and debug view, and the
// contact sheet. Pictures of the first camera lie in frames/ and in a folder a debug view; those of others in the same
// below camera_1/, and so on. Keeps other replays out of the folder. Borrows the options. Threads: one. Fails when the
// disk does, or another replay writes there.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/folder_lock.h"
#include "replay/image/png_file.h"
#include "replay/session/frame_log.h"
#include "replay/session/replay_options.h"
#include "replay/session/trace_file.h"

namespace zc {

class ReplayFiles {
 public:
  // Pictures that an earlier replay left there go, whatever its options were; nothing else does.
  // frame_count: of the whole replay.
  static Result<std::unique_ptr<ReplayFiles>> create(const ReplayOptions& options, std::size_t camera_count,
                                                     std::uint64_t frame_count);

  // Null where it was not asked for.
  [[nodiscard]] TraceFile* trace() { return trace_.get(); }

  // name: without its extension.
  Status save_picture(const Picture& picture, std::size_t camera, const std::string& name);
  Status save_debug_view(const Picture& picture, std::size_t camera, DebugView view, const std::string& name);
  // drawn: all cameras' pictures; null where nothing is drawn. Once a frame, after its pictures.
  Status end_frame(std::uint64_t frame, const FrameStatistics& paging, const FrameResult* drawn);
  // Once, with stats.json; without it frames.csv, trace.json and stats.json are as they were before.
  Status close(std::string_view statistics);

 private:
  ReplayFiles(const ReplayOptions& options, FolderLock lock, FrameLog log)
      : options_(options), lock_(std::move(lock)), log_(std::move(log)) {}

  const ReplayOptions& options_;
  FolderLock lock_;  // before what it guards
  FrameLog log_;
  std::unique_ptr<TraceFile> trace_;
  std::vector<std::size_t> sheet_frames_;  // by their order
  std::vector<Picture> sheet_tiles_;
  std::size_t frames_done_ = 0;
};

}  // namespace zc
