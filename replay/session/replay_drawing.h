// SPDX-License-Identifier: Apache-2.0
// The pictures of a replay: the stand-in host's own scene, which is the full detail, its reflections of what the replay
// pages, and the kernels that trace them.
// Owns the full detail; borrows options, device and proxies. Threads: as the device. Fails when the full detail
// does not fit into its budget, the device refuses, or a file cannot be written.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "replay/paths/camera_rig.h"
#include "replay/scene/paged_scene.h"
#include "replay/scene/rendered_scene.h"
#include "replay/session/kernel_chooser.h"
#include "replay/session/replay_files.h"
#include "replay/session/replay_options.h"
#include "replay/session/replay_statistics.h"

namespace zc {

class ReplayDrawing {
 public:
  static Result<std::unique_ptr<ReplayDrawing>> open(const ReplayOptions& options, Device& device, Source& source,
                                                     const PagedScene& proxies);

  // Every camera's picture, counted one by one and saved where there are files; returns them as one frame's.
  Result<FrameResult> draw_frame(std::uint64_t frame, const std::vector<CameraSample>& cameras, ReplayFiles* files,
                                 ReplayStatistics& statistics);
  // What measuring kernels took of the replay's time.
  [[nodiscard]] KernelChooser::Duration paused() const { return kernels_->paused(); }
  // Adds what there is to say of the device, the kernels, the full detail and what was left out.
  void describe(ReplayReport& report);

 private:
  ReplayDrawing(const ReplayOptions& options, Device& device, const PagedScene& proxies)
      : options_(options),
        device_(device),
        proxies_(proxies),
        full_detail_(device, staging_for(device, options.host_budget_bytes)) {}
  Status open_full_detail(Source& source);
  Status open_host();
  Status save_pictures(std::uint64_t frame, std::size_t which, const CameraSample& sample, const FrameCamera& camera,
                       ReplayFiles& files);

  const ReplayOptions& options_;
  Device& device_;
  const PagedScene& proxies_;
  PagedScene full_detail_;
  std::optional<KernelChooser> kernels_;
  std::unique_ptr<RenderedScene> scene_;
  bool mirrors_ = false;  // the world has a material that does
  bool sun_is_baked_ = false;
};

}  // namespace zc
