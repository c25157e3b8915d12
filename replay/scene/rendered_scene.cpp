// SPDX-License-Identifier: Apache-2.0
#include "replay/scene/rendered_scene.h"

#include <algorithm>
#include <cstddef>

#include "replay/host/zone_draws.h"

namespace zc {
namespace {

std::uint32_t deepest_page(const IndexView& index) {
  std::uint32_t depth = 1;
  for (std::uint32_t n = 0; n < index.nodes.size(); ++n) depth = std::max(depth, index.nodes[n].bvh_depth);
  return depth;
}

std::vector<gpu::MaterialEntry> material_entries(const IndexView& index) {
  std::vector<gpu::MaterialEntry> entries;
  for (const MaterialRecord& m : index.materials)
    entries.push_back({m.base_color[0], m.base_color[1], m.base_color[2], m.roughness, m.metallic, m.flags, 0, 0});
  return entries;
}

}  // namespace

void fit_to_world(HostOptions& options, const IndexView& index, const std::optional<SunAngles>& asked) {
  const std::optional<SunAngles> baked = SunAngles::unpack(index.header.sun);
  const SunAngles sun = asked.value_or(baked.value_or(SunAngles{145, 38}));
  options.sun_azimuth_deg = sun.azimuth_deg;
  options.sun_elevation_deg = sun.elevation_deg;
  options.sun_is_baked = baked && sun.elevation_deg >= 0 && sun.pack() == index.header.sun;
  options.page_depth = deepest_page(index);
}

Result<std::unique_ptr<RenderedScene>> RenderedScene::create(Device& device, const PagedScene& proxies,
                                                             const PagedScene& full_detail,
                                                             const HostOptions& options) {
  std::unique_ptr<RenderedScene> scene(new RenderedScene(proxies, full_detail, options));
  ZC_ASSIGN(scene->host_, StandInHost::create(device, proxies.zones(), full_detail.zones(),
                                              material_entries(proxies.index()), options));
  return scene;
}

Result<FrameResult> RenderedScene::draw(const FrameCamera& camera, bool cull) {
  const std::vector<ZoneDraw> draws = zone_draws(full_detail_.zones(), full_detail_.index(), camera, aspect(), cull);
  drawn_triangles_ = 0;
  for (const ZoneDraw& draw : draws) drawn_triangles_ += draw.triangle_count;
  return host_->render(camera, draws);
}

Status RenderedScene::draw_debug(DebugView view, const FrameCamera& camera) {
  return host_->draw_debug(view, zone_draws(proxies_.zones(), proxies_.index(), camera, aspect(), true));
}

Picture RenderedScene::picture() const {
  Picture picture{width_, height_, {}};
  const auto pixels = host_->pixels();
  picture.rgba.resize(pixels.size());
  std::ranges::transform(pixels, picture.rgba.begin(), [](std::byte b) { return static_cast<std::uint8_t>(b); });
  return picture;
}

}  // namespace zc
