// SPDX-License-Identifier: Apache-2.0
#include "replay/scene/paged_scene.h"

#include <utility>

#include "streamer/source/source.h"

namespace zc {
namespace {

// The streamer knows files by their names in the world; a person needs to know which world.
Error in_world(Error error, const std::filesystem::path& world) {
  const std::filesystem::path place(error.path);
  if (place.is_relative() && !is_url(error.path) && !error.path.starts_with(world.string()))
    error.path = (error.path.empty() ? world : world / place).string();
  return error;
}

}  // namespace

PagedScene::PagedScene() : heap_(std::in_place) {}

PagedScene::PagedScene(Device& device, const ZoneSetOptions& options) : zones_(std::in_place, device, options) {}

Status PagedScene::open(Source& source, const std::filesystem::path& world, const StreamerOptions& options) {
  PageSink* sink = &*heap_;
  if (zones_) sink = &*zones_;
  return open_through(*sink, source, world, options);
}

Status PagedScene::open_through(PageSink& sink, Source& source, const std::filesystem::path& world,
                                const StreamerOptions& options) {
  Result<std::unique_ptr<Streamer>> opened = Streamer::open(source, options, sink);
  if (!opened) return in_world(std::move(opened).error(), world);
  streamer_ = std::move(opened).value();
  world_ = world;
  return {};
}

Status PagedScene::advance(std::span<const View> views, double time_s) {
  Status advanced = streamer_->advance(views, time_s);
  if (!advanced.ok()) return in_world(std::move(advanced).error(), world_);
  return advanced;
}

}  // namespace zc
