// SPDX-License-Identifier: Apache-2.0
#include "replay/compare/level_view.h"

#include <span>

#include "replay/paths/frame_camera.h"

namespace zc {

Result<std::unique_ptr<LevelView>> LevelView::open(Device& device, Source& world, const CompareOptions& options,
                                                   const CompareLevel& level) {
  std::unique_ptr<LevelView> view(new LevelView(device));
  if (level.cut) view->cut_.emplace(world, *level.cut);
  StreamerOptions paging;
  paging.cap_bytes = options.budget_bytes;
  paging.threads = options.threads;
  paging.tolerance = level.tolerance;
  paging.include_detail = level.is_source;
  paging.settle = true;
  ZC_TRY(view->scene_.open(level.cut ? *view->cut_ : world, options.world, paging));
  HostOptions host = options.renderer;
  host.reflections = ReflectionMode::kNone;
  fit_to_world(host, view->scene_.index(), options.sun);
  ZC_ASSIGN(view->rendered_, RenderedScene::create(device, view->scene_, view->scene_, host));
  return view;
}

Result<Picture> LevelView::draw(const CameraSample& sample, double time_s) {
  ZC_ASSIGN(const FrameCamera camera, make_camera(scene_.index(), sample));
  const View view{sample.eye};
  ZC_TRY(scene_.streamer().advance(std::span(&view, 1), time_s));
  ZC_ASSIGN([[maybe_unused]] const FrameResult drawn, rendered_->draw(camera));
  return rendered_->picture();
}

}  // namespace zc
