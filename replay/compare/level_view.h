// SPDX-License-Identifier: Apache-2.0
// One level of a world, drawn as the stand-in host draws its scene.
// Borrows device, source and level. Threads: as the device. Fails when the level's root does not fit into its budget,
// or the device refuses.
#pragma once

#include <memory>
#include <optional>

#include "replay/compare/compare_levels.h"
#include "replay/compare/level_source.h"
#include "replay/scene/paged_scene.h"
#include "replay/scene/rendered_scene.h"

namespace zc {

class LevelView {
 public:
  static Result<std::unique_ptr<LevelView>> open(Device& device, Source& world, const CompareOptions& options,
                                                 const CompareLevel& level);

  // time_s never decreases.
  Result<Picture> draw(const CameraSample& sample, double time_s);
  // Of the frame drawn last: triangles of its zones, and whether they are all as fine as the level.
  [[nodiscard]] std::uint64_t triangles() const { return rendered_->drawn_triangles(); }
  [[nodiscard]] bool complete() const { return scene_.streamer().statistics().frame.missing_nodes == 0; }

  // Where it is not complete: by what the device binds, not by the budget.
  [[nodiscard]] bool limited_by_device() const { return scene_.streamer().statistics().pool_limited_by_sink; }

 private:
  explicit LevelView(Device& device) : scene_(device) {}

  std::optional<LevelSource> cut_;
  PagedScene scene_;
  std::unique_ptr<RenderedScene> rendered_;
};

}  // namespace zc
