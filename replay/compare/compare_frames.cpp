// SPDX-License-Identifier: Apache-2.0
#include "replay/compare/compare_frames.h"

#include <algorithm>
#include <utility>

#include "replay/paths/spread_evenly.h"
#include "replay/paths/world_tour.h"

namespace zc {
namespace {

constexpr std::size_t kFrames = 8;

// Places on the path.
Result<std::vector<std::size_t>> chosen_places(const CameraPath& path, const std::optional<FrameRange>& asked) {
  if (!asked) return spread_evenly(path.size(), kFrames);
  const FrameRange frames = asked->within(path);
  if (frames.count() == 0)
    return Error{ErrorCode::kArgument, "--frames begins behind the path's " + std::to_string(path.size()) + " frames"};
  std::vector<std::size_t> places;
  for (std::uint64_t i = 0; i < frames.count(); ++i) places.push_back(frames.at(i));
  return places;
}

}  // namespace

Result<std::vector<CompareFrame>> choose_frames(Source& source, const IndexView& index, const CompareOptions& options) {
  CameraPath path = options.path;
  if (path.empty()) {
    ZC_ASSIGN(path, tour_of(source, index));
  }
  ZC_ASSIGN(const std::vector<std::size_t> places, chosen_places(path, options.frames));
  const double aspect = static_cast<double>(options.renderer.width) / options.renderer.height;
  std::vector<CompareFrame> frames;
  for (const std::size_t place : places) {
    ZC_ASSIGN(const bool sees_world, looks_at_world(index, path[place], aspect));
    frames.push_back({frame_name(path[place], place), path[place], sees_world});
  }
  if (std::ranges::none_of(frames, &CompareFrame::sees_world)) return nothing_seen(index, frames.front().camera);
  return frames;
}

}  // namespace zc
