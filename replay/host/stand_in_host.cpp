// SPDX-License-Identifier: Apache-2.0
#include "replay/host/stand_in_host.h"

#include <algorithm>
#include <cstring>
#include <glm/trigonometric.hpp>
#include <string_view>
#include <utility>

#include "base/check.h"
#include "runtime/device/commands.h"
#include "runtime/frame_data.h"
#include "spirv/host.h"

namespace zc {
namespace {

constexpr VkImageLayout kRead = VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL;
constexpr std::uint32_t kStamps = 4;  // before and after the G-buffer, before and after the composite

std::size_t pass_index(std::string_view key) {
  return static_cast<std::size_t>(std::ranges::find(kPassNames, key) - kPassNames.begin());
}

}  // namespace

Result<std::unique_ptr<StandInHost>> StandInHost::create(Device& device, const ZoneSet& proxies,
                                                         const ZoneSet& full_detail,
                                                         std::span<const gpu::MaterialEntry> materials,
                                                         const HostOptions& options) {
  std::unique_ptr<StandInHost> host(new StandInHost(device, proxies, full_detail, options));
  ZC_TRY(host->create(materials));
  return host;
}

StandInHost::~StandInHost() { vkDestroyQueryPool(device_.handle(), queries_, nullptr); }

Status StandInHost::create(std::span<const gpu::MaterialEntry> materials) {
  material_entries_.assign(materials.begin(), materials.end());
  const VkDeviceSize pixels = VkDeviceSize{options_.width} * options_.height;
  constexpr VkBufferUsageFlags storage =
      VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_TRANSFER_SRC_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT;
  ZC_TRY(create_reflections());
  ZC_TRY(targets_.create(device_, options_.width, options_.height));
  ZC_ASSIGN(frame_buffer_,
            Buffer::create(device_, sizeof(gpu::FrameData), VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT, MemoryUse::kUpload));
  ZC_ASSIGN(materials_,
            Buffer::create(device_, std::max<VkDeviceSize>(1, materials.size()) * sizeof(gpu::MaterialEntry), storage,
                           MemoryUse::kUpload));
  std::ranges::copy(std::as_bytes(materials), materials_.mapped().begin());
  ZC_ASSIGN(output_, Buffer::create(device_, pixels * 4, storage, MemoryUse::kDevice));
  ZC_ASSIGN(readback_, Buffer::create(device_, pixels * 4, VK_BUFFER_USAGE_TRANSFER_DST_BIT, MemoryUse::kReadback));
  ZC_ASSIGN(counters_, Buffer::create(device_, sizeof(gpu::Counters), storage, MemoryUse::kReadback));
  ZC_ASSIGN(no_provenance_, Buffer::create(device_, pixels * 4, storage, MemoryUse::kDevice));
  ZC_TRY(device_.run([&](VkCommandBuffer c) { vkCmdFillBuffer(c, no_provenance_.handle(), 0, VK_WHOLE_SIZE, 0); }));

  for (BindingTable* table : {&detail_table_, &proxy_table_}) {
    table->set_buffer(gpu::kBindFrame, frame_buffer_.handle());
    table->set_buffer(gpu::kBindMaterials, materials_.handle());
  }
  bind_zones(full_detail_, detail_table_);
  bind_zones(proxies_, proxy_table_);
  BindingTable& table = detail_table_;
  table.set_image(gpu::kBindDepth, targets_.depth.view(), kRead, targets_.sampler);
  table.set_image(gpu::kBindSurface, targets_.surface.view(), kRead, targets_.sampler);
  table.set_image(gpu::kBindIrradiance, targets_.irradiance.view(), kRead, targets_.sampler);
  table.set_image(gpu::kBindIrradianceOut, targets_.irradiance.view(), VK_IMAGE_LAYOUT_GENERAL);
  table.set_image(gpu::kBindReflectionIn, targets_.reflection.view(), VK_IMAGE_LAYOUT_GENERAL, targets_.sampler);
  table.set_buffer(gpu::kBindOutput, output_.handle());
  table.set_buffer(gpu::kBindCounters, counters_.handle());

  if (device_.has_timestamps()) {
    VkQueryPoolCreateInfo queries{VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO};
    queries.queryType = VK_QUERY_TYPE_TIMESTAMP;
    queries.queryCount = kStamps;
    ZC_VK(vkCreateQueryPool(device_.handle(), &queries, nullptr, &queries_));
  }
  return create_programs();
}

ReflectionsOptions StandInHost::reflections_options() const {
  ReflectionsOptions r;
  r.width = options_.width;
  r.height = options_.height;
  r.screen = options_.reflections == ReflectionMode::kScreenAndProxy;
  r.roughness_cut = options_.roughness_cut;
  r.screen_steps = options_.screen_steps;
  r.page_depth = options_.page_depth;
  r.trace = options_.trace;
  r.step_limit = options_.step_limit;
  r.frames_in_flight = 1;  // every frame is waited for and read back
  r.statistics = true;
  r.general = options_.leave_nothing_out;
  r.thread_per_pixel = options_.thread_per_pixel;
  r.check_access = options_.check_access;
  return r;
}

Status StandInHost::create_reflections() {
  if (options_.reflections == ReflectionMode::kNone) {
    reflections_.reset();
    return {};
  }
  const ZoneSet& traced = options_.reflections == ReflectionMode::kFull ? full_detail_ : proxies_;
  ZC_ASSIGN(reflections_, Reflections::create(device_, traced, material_entries_, reflections_options()));
  return {};
}

Status StandInHost::create_programs() {
  Constants constants{};
  const TraceLimits limits = trace_limits(device_, options_.page_depth, full_detail_.top_depth_bound(),
                                          full_detail_.all_as_texels(), options_.step_limit);
  constants[kConstantStackSize] = limits.stack_entries;
  constants[kConstantStepLimit] = limits.steps;
  constants[kConstantPoolPath] = nearest_fit(trace_variant(), limits).pool_path;
  constants[kConstantCheckAccess] = options_.check_access ? 1 : 0;
  ZC_ASSIGN(light_, programs_.compute("light_surfaces", shader::light_surfaces(), constants));
  ZC_ASSIGN(composite_, programs_.compute("composite_frame", shader::composite_frame(), constants));
  ZC_ASSIGN(debug_, programs_.compute("show_debug", shader::show_debug(), constants));
  GraphicsState state;
  state.width = options_.width;
  state.height = options_.height;
  state.render_pass = targets_.gbuffer_pass;
  ZC_ASSIGN(draw_zone_, Program::create_graphics(device_, "draw_zone", shader::draw_zone_vert(),
                                                 shader::draw_zone_frag(), state, constants));
  state.render_pass = targets_.overlay_pass;
  state.topology = VK_PRIMITIVE_TOPOLOGY_LINE_LIST;
  state.depth_write = false;
  ZC_ASSIGN(draw_lines_, Program::create_graphics(device_, "draw_lines", shader::draw_lines_vert(),
                                                  shader::draw_lines_frag(), state, constants));
  return {};
}

Status StandInHost::reconfigure(const HostOptions& options) {
  const bool same_zones =
      (options.reflections == ReflectionMode::kFull) == (options_.reflections == ReflectionMode::kFull);
  options_ = options;
  if (!same_zones || reflections_ == nullptr || options.reflections == ReflectionMode::kNone)
    return create_reflections();
  return reflections_->reconfigure(reflections_options());
}

const TraceVariant& StandInHost::trace_variant() const {
  return reflections_ != nullptr ? reflections_->trace_variant() : options_.trace;
}

Result<bool> StandInHost::choose_trace_variant(std::uint32_t ray_count, double budget_ms) {
  ZC_CHECK(reflections_ != nullptr);
  ZC_ASSIGN(const bool complete, reflections_->choose_trace_variant(ray_count, budget_ms));
  options_.trace = reflections_->trace_variant();
  ZC_TRY(create_programs());  // what else reads pages reads them the same way
  return complete;
}

std::vector<LeftOutPass> StandInHost::left_out() const {
  if (reflections_ != nullptr) return reflections_->left_out();
  return {{"hiz, classify, ssr, compact, trace, shade", "nothing is reflected"}};
}

void StandInHost::write_frame(const FrameCamera& camera) {
  previous_camera_ = std::exchange(camera_, camera);
  const float azimuth = glm::radians(options_.sun_azimuth_deg);
  const float elevation = glm::radians(options_.sun_elevation_deg);
  FrameSun sun;
  sun.direction = {std::sin(azimuth) * std::cos(elevation), std::cos(azimuth) * std::cos(elevation),
                   std::sin(elevation)};
  sun.is_baked = options_.sun_is_baked;
  sun_ = sun;
  fill_frame_data(camera, sun, options_.width, options_.height, frame_);
  fill_frame_data(full_detail_, frame_);
  frame_.roughness_cut = options_.roughness_cut;
  std::memcpy(frame_buffer_.mapped().data(), &frame_, sizeof(frame_));
}

void StandInHost::dispatch_pixels(VkCommandBuffer c, Program& program, const gpu::PassConstants* constants) {
  program.bind(c, detail_table_, 0);
  if (constants != nullptr) program.push(c, std::as_bytes(std::span(constants, 1)));
  const auto& group = program.workgroup();
  vkCmdDispatch(c, (options_.width + group[0] - 1) / group[0], (options_.height + group[1] - 1) / group[1], 1);
  barrier_after_compute(c);
}

void StandInHost::stamp(VkCommandBuffer c, std::uint32_t index) const {
  if (queries_ != VK_NULL_HANDLE) vkCmdWriteTimestamp(c, VK_PIPELINE_STAGE_BOTTOM_OF_PIPE_BIT, queries_, index);
}

void StandInHost::record_gbuffer(VkCommandBuffer c, std::span<const ZoneDraw> draws) {
  const std::array<VkClearValue, 2> clear = {};
  VkRenderPassBeginInfo begin{VK_STRUCTURE_TYPE_RENDER_PASS_BEGIN_INFO};
  begin.renderPass = targets_.gbuffer_pass;
  begin.framebuffer = targets_.gbuffer;
  begin.renderArea = {{0, 0}, {options_.width, options_.height}};
  begin.clearValueCount = static_cast<std::uint32_t>(clear.size());
  begin.pClearValues = clear.data();
  vkCmdBeginRenderPass(c, &begin, VK_SUBPASS_CONTENTS_INLINE);
  draw_zone_->bind(c, detail_table_, 0);
  for (const ZoneDraw& draw : draws) vkCmdDraw(c, draw.triangle_count * 3, 1, 0, draw.slot);
  vkCmdEndRenderPass(c);
}

void StandInHost::record_readback(VkCommandBuffer c) const {
  const VkBufferCopy picture{0, 0, output_.bytes()};
  vkCmdCopyBuffer(c, output_.handle(), readback_.handle(), 1, &picture);
  barrier_after_transfer(c);
}

Result<FrameResult> StandInHost::render(const FrameCamera& camera, std::span<const ZoneDraw> draws) {
  write_frame(camera);
  gpu::Counters own{};
  std::memcpy(counters_.mapped().data(), &own, sizeof(own));
  ZC_TRY(device_.run([&](VkCommandBuffer c) {
    if (queries_ != VK_NULL_HANDLE) vkCmdResetQueryPool(c, queries_, 0, kStamps);
    stamp(c, 0);
    record_gbuffer(c, draws);
    change_layout(c, targets_.irradiance, VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_GENERAL);
    dispatch_pixels(c, *light_);
    change_layout(c, targets_.irradiance, VK_IMAGE_LAYOUT_GENERAL, kRead);
    stamp(c, 1);
  }));
  // By itself: llvmpipe since Mesa 23 takes timestamps behind draws only once the next pass has run.
  Status recorded;
  ZC_TRY(device_.run([&](VkCommandBuffer c) {
    if (reflections_ != nullptr) {
      HostFrame frame;
      frame.camera = camera_;
      frame.previous = previous_camera_;
      frame.sun = sun_;
      frame.depth = targets_.depth.view();
      frame.surface = targets_.surface.view();
      frame.irradiance = targets_.irradiance.view();
      recorded = reflections_->record(c, frame, targets_.reflection.view());
    }
    stamp(c, 2);
    dispatch_pixels(c, *composite_);
    stamp(c, 3);
    record_readback(c);
  }));
  ZC_TRY(std::move(recorded));

  FrameResult result;
  std::array<std::uint64_t, kStamps> ticks{};
  if (queries_ != VK_NULL_HANDLE)
    ZC_VK(vkGetQueryPoolResults(device_.handle(), queries_, 0, kStamps, sizeof(ticks), ticks.data(), sizeof(ticks[0]),
                                VK_QUERY_RESULT_64_BIT | VK_QUERY_RESULT_WAIT_BIT));
  result.pass_ms[pass_index("gbuffer")] = device_.elapsed_ms(ticks[0], ticks[1]);
  result.pass_ms[pass_index("composite")] = device_.elapsed_ms(ticks[2], ticks[3]);
  if (reflections_ != nullptr) {
    ZC_ASSIGN(const FrameReport report, reflections_->report());
    result.counters = report.counters;
    for (const PassTime& pass : report.passes) {
      const std::size_t index = pass_index(pass.key);
      if (index < kPassCount) result.pass_ms[index] += pass.ms;
    }
  }
  std::memcpy(&own, counters_.mapped().data(), sizeof(own));
  result.counters.out_of_page += own.out_of_page;
  result.total_ms = device_.elapsed_ms(ticks[0], ticks[3]);
  return result;
}

void StandInHost::record_lines(VkCommandBuffer c, std::span<const ZoneDraw> draws) {
  change_layout(c, targets_.overlay, VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL);
  const VkBufferImageCopy region{
      0, 0, 0, {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1}, {0, 0, 0}, {options_.width, options_.height, 1}};
  const VkImage overlay = targets_.overlay.handle();
  vkCmdCopyBufferToImage(c, output_.handle(), overlay, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, 1, &region);
  // The picture comes back into the buffer that it was copied from.
  memory_barrier(c, VK_PIPELINE_STAGE_TRANSFER_BIT, VK_ACCESS_TRANSFER_READ_BIT, VK_PIPELINE_STAGE_TRANSFER_BIT,
                 VK_ACCESS_TRANSFER_WRITE_BIT);
  VkRenderPassBeginInfo begin{VK_STRUCTURE_TYPE_RENDER_PASS_BEGIN_INFO};
  begin.renderPass = targets_.overlay_pass;
  begin.framebuffer = targets_.overlay_target;
  begin.renderArea = {{0, 0}, {options_.width, options_.height}};
  vkCmdBeginRenderPass(c, &begin, VK_SUBPASS_CONTENTS_INLINE);
  draw_lines_->bind(c, proxy_table_, 0);
  for (const std::uint32_t boxes : {1U, 0U}) {
    const gpu::PassConstants constants{boxes, 0, 0, 0};
    draw_lines_->push(c, std::as_bytes(std::span(&constants, 1)));
    for (const ZoneDraw& draw : draws)
      vkCmdDraw(c, boxes == 1 ? draw.node_count * 192 : draw.triangle_count * 6, 1, 0, draw.slot);
  }
  vkCmdEndRenderPass(c);
  vkCmdCopyImageToBuffer(c, overlay, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, output_.handle(), 1, &region);
  barrier_after_transfer(c);
}

Status StandInHost::draw_debug(DebugView view, std::span<const ZoneDraw> proxy_draws) {
  const Buffer& provenance = reflections_ != nullptr ? reflections_->provenance() : no_provenance_;
  detail_table_.set_buffer(gpu::kBindProvenance, provenance.handle());
  return device_.run([&](VkCommandBuffer c) {
    if (view == DebugView::kBvh) {
      dispatch_pixels(c, *composite_);
      record_lines(c, proxy_draws);
    } else {
      const gpu::PassConstants constants{view == DebugView::kProvenance ? gpu::kDebugProvenance
                                         : view == DebugView::kNormals  ? gpu::kDebugNormals
                                                                        : gpu::kDebugDepth,
                                         0, 0, 0};
      dispatch_pixels(c, *debug_, &constants);
    }
    record_readback(c);
  });
}

std::span<const std::byte> StandInHost::pixels() const { return readback_.mapped(); }

}  // namespace zc
