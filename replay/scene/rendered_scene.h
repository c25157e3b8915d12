// SPDX-License-Identifier: Apache-2.0
// A world's zones under the stand-in host: some that it draws, some that its reflections are traced against.
// Owns the host; borrows the device and the scenes, which are open. Threads: as the device. Fails when the driver
// refuses.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "replay/host/stand_in_host.h"
#include "replay/image/png_file.h"
#include "replay/scene/paged_scene.h"
#include "streamer/world_format/sun_angles.h"

namespace zc {

// What the world says of how it is drawn: how deep its pages are, and the sun. That is the one asked for, else the
// bake's, else 145,38.
void fit_to_world(HostOptions& options, const IndexView& index, const std::optional<SunAngles>& asked);

class RenderedScene {
 public:
  // full_detail: may be the proxies.
  static Result<std::unique_ptr<RenderedScene>> create(Device& device, const PagedScene& proxies,
                                                       const PagedScene& full_detail, const HostOptions& options);

  // cull: zones outside the view are not drawn.
  Result<FrameResult> draw(const FrameCamera& camera, bool cull = true);
  // Of the zones that the last frame drew.
  [[nodiscard]] std::uint64_t drawn_triangles() const { return drawn_triangles_; }
  // Replaces the picture of that frame, which the same camera saw.
  Status draw_debug(DebugView view, const FrameCamera& camera);
  [[nodiscard]] Picture picture() const;

  [[nodiscard]] StandInHost& host() { return *host_; }

 private:
  RenderedScene(const PagedScene& proxies, const PagedScene& full_detail, const HostOptions& options)
      : proxies_(proxies), full_detail_(full_detail), width_(options.width), height_(options.height) {}
  [[nodiscard]] double aspect() const { return static_cast<double>(width_) / height_; }

  const PagedScene& proxies_;
  const PagedScene& full_detail_;
  std::uint32_t width_, height_;
  std::unique_ptr<StandInHost> host_;
  std::uint64_t drawn_triangles_ = 0;
};

}  // namespace zc
