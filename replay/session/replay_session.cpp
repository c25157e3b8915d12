// SPDX-License-Identifier: Apache-2.0
#include "replay/session/replay_session.h"

#include <chrono>
#include <memory>
#include <optional>
#include <span>
#include <thread>

#include "replay/paths/world_tour.h"
#include "replay/scene/paged_scene.h"
#include "replay/session/replay_drawing.h"
#include "replay/session/replay_files.h"
#include "replay/session/replay_statistics.h"
#include "replay/session/statistics_json.h"
#include "streamer/open_source.h"
#include "streamer/statistics/belady.h"

namespace zc {
namespace {

// What is kept of the frames' selections for what an eviction that knows the future would have read: 4 MiB.
constexpr std::size_t kSelectionLimitWords = 1U << 20U;

class Session {
  using Clock = std::chrono::steady_clock;

 public:
  explicit Session(const ReplayOptions& options) : options_(options) {}

  Result<ReplayReport> run() {
    ZC_ASSIGN(source_, open_source(options_.world, options_.source));
    if (options_.render) {
      ZC_ASSIGN(device_, Device::create({options_.device, options_.validation}));
    }
    statistics_.begin();
    ZC_TRY(open_world());
    scene_->streamer().observe(selections_);
    ZC_TRY(place_cameras());
    if (!options_.out.empty()) ZC_TRY(open_files());
    ZC_TRY(replay_frames());
    ReplayReport report = make_report();
    if (files_) ZC_TRY(files_->close(statistics_text(report)));
    return report;
  }

 private:
  Status open_world() {
    if (device_)
      scene_.emplace(*device_, staging_for(*device_, options_.streamer.cap_bytes));
    else
      scene_.emplace();
    StreamerOptions paging = options_.streamer;
    paging.on_failure = options_.on_failure;
    ZC_TRY(scene_->open(*source_, options_.world, paging));
    if (device_) {
      ZC_ASSIGN(drawing_, ReplayDrawing::open(options_, *device_, *source_, *scene_));
    }
    return {};
  }

  // Before anything is written: a path must not turn out to be useless after an hour.
  Status place_cameras() {
    if (options_.paths.empty()) {
      ZC_ASSIGN(tour_, tour_of(*source_, scene_->index()));
    }
    const std::span<const CameraPath> paths = options_.paths.empty() ? std::span(&tour_, 1) : std::span(options_.paths);
    cameras_.emplace(paths, options_.look_ahead_s, options_.prediction);
    const CameraPath& lead = cameras_->lead();
    frames_ = options_.frames.within(lead);
    if (frames_.count() == 0)
      return Error{ErrorCode::kArgument,
                   "the path has " + std::to_string(lead.size()) + " samples, none of them in the frames asked for"};
    ZC_ASSIGN(const bool seen, cameras_->sees_world(scene_->index(), frames_, options_.aspect()));
    if (!seen) options_.warn(nothing_seen(scene_->index(), lead[frames_.begin]));
    return {};
  }

  Status open_files() {
    ZC_ASSIGN(files_, ReplayFiles::create(options_, cameras_->size(), frames_.count()));
    if (files_->trace() != nullptr) scene_->streamer().observe(*files_->trace());
    return {};
  }

  Status replay_frames() {
    started_ = Clock::now();
    for (std::uint64_t i = 0; i < frames_.count(); ++i) {
      ZC_TRY(replay_frame(frames_.at(i)));
      if (options_.progress) options_.progress(i + 1, frames_.count());
    }
    return {};
  }

  Status replay_frame(std::uint64_t frame) {
    const std::vector<CameraSample> cameras = cameras_->cameras(frame);
    const double time_s = cameras.front().time_s;
    if (options_.streamer.clock == ClockKind::kWall) std::this_thread::sleep_until(wall_time_of(time_s));
    Streamer& streamer = scene_->streamer();
    const Clock::time_point began = Clock::now();
    ZC_TRY(scene_->advance(cameras_->look_ahead(cameras), time_s));
    if (files_ && files_->trace() != nullptr)
      files_->trace()->add_frame(frame, began, Clock::now(), streamer.statistics());
    std::optional<FrameResult> drawn;
    if (drawing_) {
      ZC_ASSIGN(drawn, drawing_->draw_frame(frame, cameras, files_.get(), statistics_));
    }
    statistics_.end_frame();
    if (files_) ZC_TRY(files_->end_frame(frame, streamer.statistics().frame, drawn ? &*drawn : nullptr));
    return {};
  }

  // When a wall clock shows a time of the path.
  [[nodiscard]] Clock::time_point wall_time_of(double time_s) const {
    const auto paused = drawing_ ? drawing_->paused() : Clock::duration();
    const double first_s = cameras_->lead()[frames_.begin].time_s;
    return started_ + paused +
           std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(time_s - first_s));
  }

  ReplayReport make_report() {
    const StreamerStatistics streaming = scene_->streamer().statistics();
    const auto optimal = optimal_paging(selections_, scene_->index(), streaming.pool_bytes);
    ReplayReport report = statistics_.report();
    report.streaming = streaming;
    report.optimal = optimal;
    report.source = source_->statistics();
    report_pool_limit("", streaming, report);
    if (drawing_)
      drawing_->describe(report);
    else
      report.left_out.emplace_back("render: not asked for");
    return report;
  }

  const ReplayOptions& options_;
  ReplayStatistics statistics_;
  std::unique_ptr<Source> source_;
  std::unique_ptr<Device> device_;
  std::unique_ptr<ReplayFiles> files_;
  SelectionTrace selections_{kSelectionLimitWords};
  std::optional<PagedScene> scene_;         // what is paged does not depend on whether it is drawn
  std::unique_ptr<ReplayDrawing> drawing_;  // null: nothing is drawn
  CameraPath tour_;                         // where no path was given
  std::optional<CameraRig> cameras_;
  FrameRange frames_;
  Clock::time_point started_;  // on the path's first frame
};

}  // namespace

Result<ReplayReport> run_replay(const ReplayOptions& options) { return Session(options).run(); }

}  // namespace zc
