// SPDX-License-Identifier: Apache-2.0
#include "runtime/renderer.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>
#include <utility>

#include "base/check.h"

namespace zc {
namespace {

constexpr float kNear_m = 0.1F;
// Passes in the order that a frame stamps them; mirrors need no filter.
constexpr std::array kStamped = {Pass::kGbuffer, Pass::kHiz,   Pass::kClassify, Pass::kSsr,
                                 Pass::kCompact, Pass::kTrace, Pass::kShade,    Pass::kComposite};
// Of choose_trace_variant.
constexpr double kRoundMs = 5;
constexpr int kRounds = 5;
constexpr std::uint32_t kRun = 64;                // rays that stay together: a packet
constexpr std::uint32_t kRaysAtMost = 1U << 20U;  // keep any device busy

void barrier(VkCommandBuffer c, VkPipelineStageFlags from, VkAccessFlags written, VkPipelineStageFlags to,
             VkAccessFlags read) {
  VkMemoryBarrier b{VK_STRUCTURE_TYPE_MEMORY_BARRIER};
  b.srcAccessMask = written;
  b.dstAccessMask = read;
  vkCmdPipelineBarrier(c, from, to, 0, 1, &b, 0, nullptr, 0, nullptr);
}

// Between passes that read what the one before wrote.
void next_pass(VkCommandBuffer c) {
  barrier(c, VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT, VK_ACCESS_SHADER_WRITE_BIT,
          VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT | VK_PIPELINE_STAGE_DRAW_INDIRECT_BIT | VK_PIPELINE_STAGE_TRANSFER_BIT,
          VK_ACCESS_SHADER_READ_BIT | VK_ACCESS_SHADER_WRITE_BIT | VK_ACCESS_INDIRECT_COMMAND_READ_BIT |
              VK_ACCESS_TRANSFER_READ_BIT);
}

void after_transfer(VkCommandBuffer c) {
  barrier(c, VK_PIPELINE_STAGE_TRANSFER_BIT, VK_ACCESS_TRANSFER_WRITE_BIT,
          VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT | VK_PIPELINE_STAGE_HOST_BIT | VK_PIPELINE_STAGE_TRANSFER_BIT,
          VK_ACCESS_SHADER_READ_BIT | VK_ACCESS_SHADER_WRITE_BIT | VK_ACCESS_HOST_READ_BIT |
              VK_ACCESS_TRANSFER_READ_BIT | VK_ACCESS_TRANSFER_WRITE_BIT);
}

gpu::vec4 to_vec4(const glm::vec3& v, float w) { return {v.x, v.y, v.z, w}; }

}  // namespace

void Renderer::write_frame(const RenderCamera& camera) {
  const float tan_y = std::tan(glm::radians(camera.fov_y_deg) * 0.5F);
  const float tan_x = tan_y * static_cast<float>(options_.width) / static_cast<float>(options_.height);
  // Rows of the projection: x right, y down (Vulkan), reversed Z with the far plane at infinity; w = view distance.
  const glm::vec3 x = camera.right / tan_x;
  const glm::vec3 y = -camera.up / tan_y;
  const glm::vec3& z = camera.forward;
  for (int column = 0; column < 3; ++column)
    frame_.view_projection.column[column] = {x[column], y[column], 0, z[column]};
  frame_.view_projection.column[3] = {-glm::dot(x, camera.eye), -glm::dot(y, camera.eye), kNear_m,
                                      -glm::dot(z, camera.eye)};
  frame_.eye = to_vec4(camera.eye, kNear_m);
  frame_.right = to_vec4(camera.right, tan_x);
  frame_.up = to_vec4(camera.up, tan_y);
  frame_.forward = to_vec4(camera.forward, camera.ray_length_m);
  const float azimuth = glm::radians(options_.sun_azimuth_deg);
  const float elevation = glm::radians(options_.sun_elevation_deg);
  frame_.sun_direction = {std::sin(azimuth) * std::cos(elevation), std::cos(azimuth) * std::cos(elevation),
                          std::sin(elevation), options_.roughness_cut};
  frame_.sun_radiance = {1.75F, 1.58F, 1.32F, static_cast<float>(camera.step_m)};
  frame_.sets = {proxies_.root_word(), proxies_.zone_count(), host_.root_word(), host_.zone_count()};
  frame_.set_ends = {proxies_.end_word(), host_.end_word(), options_.sun_is_baked ? 1U : 0U, 0};
  frame_.camera_lattice = {camera.lattice[0], camera.lattice[1], camera.lattice[2], 0};
  std::memcpy(frame_buffer_.mapped().data(), &frame_, sizeof(frame_));
}

void Renderer::bind(VkCommandBuffer c, const Pipeline& pipeline) const {
  vkCmdBindPipeline(c, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline.handle());
  const VkDescriptorSet set = layout_.set();
  vkCmdBindDescriptorSets(c, VK_PIPELINE_BIND_POINT_COMPUTE, layout_.pipeline_layout(), 0, 1, &set, 0, nullptr);
}

void Renderer::dispatch_pixels(VkCommandBuffer c, const Pipeline& pipeline, std::uint32_t width, std::uint32_t height,
                               const gpu::PassConstants& constants) const {
  bind(c, pipeline);
  vkCmdPushConstants(c, layout_.pipeline_layout(), VK_SHADER_STAGE_COMPUTE_BIT | VK_SHADER_STAGE_VERTEX_BIT, 0,
                     sizeof(constants), &constants);
  vkCmdDispatch(c, (width + 7) / 8, (height + 7) / 8, 1);
  next_pass(c);
}

void Renderer::dispatch_indirect(VkCommandBuffer c, const Pipeline& pipeline, std::size_t offset_bytes) const {
  bind(c, pipeline);
  vkCmdDispatchIndirect(c, counters_.handle(), offset_bytes);
  next_pass(c);
}

void Renderer::record_trace(VkCommandBuffer c, const TraceKernels& kernels) const {
  if (kernels.packets.handle() != VK_NULL_HANDLE) {
    dispatch_indirect(c, kernels.packets, offsetof(gpu::Counters, packet_groups_x));
    dispatch_pixels(c, kernels.size, 1, 1);
  }
  dispatch_indirect(c, kernels.rays, offsetof(gpu::Counters, fallback_groups_x));
}

void Renderer::stamp(VkCommandBuffer c, std::uint32_t index) const {
  if (device_.has_timestamps()) vkCmdWriteTimestamp(c, VK_PIPELINE_STAGE_BOTTOM_OF_PIPE_BIT, queries_, index);
}

Status Renderer::read_stamps(std::span<std::uint64_t> ticks) const {
  if (!device_.has_timestamps()) return {};
  return vk_status(
      vkGetQueryPoolResults(device_.handle(), queries_, 0, static_cast<std::uint32_t>(ticks.size()), ticks.size_bytes(),
                            ticks.data(), sizeof(std::uint64_t), VK_QUERY_RESULT_64_BIT | VK_QUERY_RESULT_WAIT_BIT),
      "vkGetQueryPoolResults");
}

void Renderer::record_gbuffer(VkCommandBuffer c, std::span<const ZoneDraw> draws) const {
  const std::array<VkClearValue, 2> clear = {};
  VkRenderPassBeginInfo begin{VK_STRUCTURE_TYPE_RENDER_PASS_BEGIN_INFO};
  begin.renderPass = gbuffer_pass_;
  begin.framebuffer = gbuffer_target_;
  begin.renderArea = {{0, 0}, {options_.width, options_.height}};
  begin.clearValueCount = static_cast<std::uint32_t>(clear.size());
  begin.pClearValues = clear.data();
  vkCmdBeginRenderPass(c, &begin, VK_SUBPASS_CONTENTS_INLINE);
  vkCmdBindPipeline(c, VK_PIPELINE_BIND_POINT_GRAPHICS, draw_zone_.handle());
  const VkDescriptorSet set = layout_.set();
  vkCmdBindDescriptorSets(c, VK_PIPELINE_BIND_POINT_GRAPHICS, layout_.pipeline_layout(), 0, 1, &set, 0, nullptr);
  for (const ZoneDraw& draw : draws) vkCmdDraw(c, draw.triangle_count * 3, 1, 0, draw.slot);
  vkCmdEndRenderPass(c);
}

void Renderer::record_readback(VkCommandBuffer c) const {
  const VkBufferCopy picture{0, 0, output_.bytes()};
  vkCmdCopyBuffer(c, output_.handle(), readback_.handle(), 1, &picture);
  const VkBufferCopy counters{0, 0, sizeof(gpu::Counters)};
  vkCmdCopyBuffer(c, counters_.handle(), counters_readback_.handle(), 1, &counters);
  after_transfer(c);
}

Result<FrameResult> Renderer::render(const RenderCamera& camera, std::span<const ZoneDraw> host_draws) {
  write_frame(camera);
  const auto w = options_.width;
  const auto h = options_.height;
  const bool trace = options_.reflections != ReflectionMode::kNone;
  const bool hiz = options_.reflections == ReflectionMode::kScreenAndProxy;
  ZC_ASSIGN(const TraceKernels* kernels, this->kernels({.host = options_.reflections == ReflectionMode::kFull}));

  ZC_TRY(device_.run([&](VkCommandBuffer c) {
    vkCmdResetQueryPool(c, queries_, 0, kPassCount + 1);
    stamp(c, 0);
    vkCmdFillBuffer(c, counters_.handle(), 0, VK_WHOLE_SIZE, 0);
    after_transfer(c);
    record_gbuffer(c, host_draws);
    dispatch_pixels(c, light_, w, h);
    stamp(c, 1);
  }));
  // By itself: llvmpipe since Mesa 23 takes timestamps behind draws only once the next pass has run.
  ZC_TRY(device_.run([&](VkCommandBuffer c) {
    if (hiz) {
      for (std::uint32_t level = 0; level < frame_.size.z; ++level)
        dispatch_pixels(c, reduce_, frame_.hiz_offset[level].y, frame_.hiz_offset[level].z, {level, 0, 0, 0});
    }
    stamp(c, 2);
    dispatch_pixels(c, classify_, (w + 7) / 8, (h + 7) / 8);  // a tile an invocation
    dispatch_pixels(c, kernels->size, 1, 1);
    stamp(c, 3);
    if (trace) dispatch_indirect(c, march_, offsetof(gpu::Counters, ssr_groups_x));
    stamp(c, 4);
    if (trace) dispatch_pixels(c, kernels->size, 1, 1);
    stamp(c, 5);
    if (trace) record_trace(c, *kernels);
    stamp(c, 6);
    if (trace) dispatch_indirect(c, shade_, offsetof(gpu::Counters, trace_groups_x));
    stamp(c, 7);
    dispatch_pixels(c, composite_, w, h);
    stamp(c, 8);
    record_readback(c);
  }));

  FrameResult result;
  result.counters = this->counters();
  if (!trace) result.counters.pixel_count = 0;  // found, but no ray left them
  std::array<std::uint64_t, kStamped.size() + 1> ticks{};
  ZC_TRY(read_stamps(ticks));
  for (std::size_t i = 0; i < kStamped.size(); ++i)
    result.pass_ms[static_cast<std::size_t>(kStamped[i])] = device_.elapsed_ms(ticks[i], ticks[i + 1]);
  result.total_ms = device_.elapsed_ms(ticks.front(), ticks.back());
  return result;
}

void Renderer::record_lines(VkCommandBuffer c, std::span<const ZoneDraw> draws) const {
  VkImageMemoryBarrier fresh{VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER};
  fresh.dstAccessMask = VK_ACCESS_TRANSFER_WRITE_BIT;
  fresh.oldLayout = VK_IMAGE_LAYOUT_UNDEFINED;
  fresh.newLayout = VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL;
  fresh.srcQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED;
  fresh.dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED;
  fresh.image = overlay_.handle();
  fresh.subresourceRange = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, 1};
  vkCmdPipelineBarrier(c, VK_PIPELINE_STAGE_ALL_COMMANDS_BIT, VK_PIPELINE_STAGE_TRANSFER_BIT, 0, 0, nullptr, 0, nullptr,
                       1, &fresh);
  const VkBufferImageCopy region{
      0, 0, 0, {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1}, {0, 0, 0}, {options_.width, options_.height, 1}};
  vkCmdCopyBufferToImage(c, output_.handle(), overlay_.handle(), VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, 1, &region);
  // The picture comes back into the buffer that it was copied from.
  barrier(c, VK_PIPELINE_STAGE_TRANSFER_BIT, VK_ACCESS_TRANSFER_READ_BIT, VK_PIPELINE_STAGE_TRANSFER_BIT,
          VK_ACCESS_TRANSFER_WRITE_BIT);

  VkRenderPassBeginInfo begin{VK_STRUCTURE_TYPE_RENDER_PASS_BEGIN_INFO};
  begin.renderPass = overlay_pass_;
  begin.framebuffer = overlay_target_;
  begin.renderArea = {{0, 0}, {options_.width, options_.height}};
  vkCmdBeginRenderPass(c, &begin, VK_SUBPASS_CONTENTS_INLINE);
  vkCmdBindPipeline(c, VK_PIPELINE_BIND_POINT_GRAPHICS, draw_lines_.handle());
  const VkDescriptorSet set = layout_.set();
  vkCmdBindDescriptorSets(c, VK_PIPELINE_BIND_POINT_GRAPHICS, layout_.pipeline_layout(), 0, 1, &set, 0, nullptr);
  for (const std::uint32_t boxes : {1U, 0U}) {
    const gpu::PassConstants constants{boxes, 0, 0, 0};
    vkCmdPushConstants(c, layout_.pipeline_layout(), VK_SHADER_STAGE_COMPUTE_BIT | VK_SHADER_STAGE_VERTEX_BIT, 0,
                       sizeof(constants), &constants);
    for (const ZoneDraw& draw : draws)
      vkCmdDraw(c, boxes == 1 ? draw.node_count * 192 : draw.triangle_count * 6, 1, 0, draw.slot);
  }
  vkCmdEndRenderPass(c);
  vkCmdCopyImageToBuffer(c, overlay_.handle(), VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, output_.handle(), 1, &region);
  after_transfer(c);
}

Status Renderer::draw_debug(DebugView view, std::span<const ZoneDraw> proxy_draws) {
  return device_.run([&](VkCommandBuffer c) {
    if (view == DebugView::kBvh) {
      dispatch_pixels(c, composite_, options_.width, options_.height);
      record_lines(c, proxy_draws);
    } else {
      const std::uint32_t kind = view == DebugView::kProvenance ? gpu::kDebugProvenance
                                 : view == DebugView::kNormals  ? gpu::kDebugNormals
                                                                : gpu::kDebugDepth;
      dispatch_pixels(c, debug_, options_.width, options_.height, {kind, 0, 0, 0});
    }
    record_readback(c);
  });
}

std::span<const std::byte> Renderer::pixels() const {
  return readback_.mapped().first(static_cast<std::size_t>(output_.bytes()));
}

gpu::Counters Renderer::counters() const {
  gpu::Counters counters;
  std::memcpy(&counters, counters_readback_.mapped().data(), sizeof counters);
  return counters;
}

Result<double> Renderer::trace_queue(const TraceKernels& kernels, std::uint32_t ray_count) {
  gpu::Counters counters{};
  counters.ray_count = ray_count;
  std::memcpy(counters_readback_.mapped().data(), &counters, sizeof(counters));
  ZC_TRY(device_.run([&](VkCommandBuffer c) {
    const VkBufferCopy block{0, 0, sizeof(counters)};
    vkCmdCopyBuffer(c, counters_readback_.handle(), counters_.handle(), 1, &block);
    after_transfer(c);
    dispatch_pixels(c, kernels.size, 1, 1);
  }));
  const auto start = std::chrono::steady_clock::now();
  ZC_TRY(device_.run([&](VkCommandBuffer c) {
    vkCmdResetQueryPool(c, queries_, 0, 2);
    stamp(c, 0);
    record_trace(c, kernels);
    stamp(c, 1);
  }));
  if (!device_.has_timestamps())
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
  std::array<std::uint64_t, 2> ticks{};
  ZC_TRY(read_stamps(ticks));
  return device_.elapsed_ms(ticks[0], ticks[1]);
}

Status Renderer::thin_queue(std::uint32_t ray_count, std::uint32_t runs) {
  std::vector<VkBufferCopy> out;
  for (std::uint32_t run = 0; run < runs; ++run) {
    const VkDeviceSize from = VkDeviceSize{run} * (ray_count / kRun) / runs;
    out.push_back({from * kRun * sizeof(gpu::RayTask), VkDeviceSize{run} * kRun * sizeof(gpu::RayTask),
                   kRun * sizeof(gpu::RayTask)});
  }
  return device_.run([&](VkCommandBuffer c) {
    vkCmdCopyBuffer(c, rays_.handle(), readback_.handle(), runs, out.data());
    after_transfer(c);
    const VkBufferCopy back{0, 0, VkDeviceSize{runs} * kRun * sizeof(gpu::RayTask)};
    vkCmdCopyBuffer(c, readback_.handle(), rays_.handle(), 1, &back);
    after_transfer(c);
  });
}

Result<bool> Renderer::choose_trace_variant(std::uint32_t ray_count, bool host, double budget_ms) {
  ZC_CHECK(ray_count >= kRaysToChoose);
  // Of slow devices only as many rays as the kernels in use trace in kRoundMs.
  ZC_ASSIGN(const TraceKernels* used, kernels({.host = host}));
  ZC_ASSIGN(const double whole_ms, trace_queue(*used, ray_count));
  const double in_round = ray_count * kRoundMs / std::max(whole_ms, 1e-6);
  const auto rays =
      static_cast<std::uint32_t>(std::clamp<double>(in_round, kRaysToChoose, std::min(ray_count, kRaysAtMost)));
  if (rays < ray_count) ZC_TRY(thin_queue(ray_count, rays / kRun));
  const auto start = std::chrono::steady_clock::now();
  const auto elapsed_ms = [&] {
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
  };
  bool complete = true;

  std::vector<std::pair<TraceVariant, TraceKernels>> made;
  std::optional<TraceKernels>& in_use = host ? kernels_host_ : kernels_proxies_;
  made.emplace_back(options_.trace, *std::exchange(in_use, std::nullopt));
  const auto make = [&](const TraceVariant& variant) -> Result<std::size_t> {
    const auto known = std::ranges::find(made, variant, &std::pair<TraceVariant, TraceKernels>::first);
    const auto place = static_cast<std::size_t>(known - made.begin());
    if (known != made.end()) return place;
    ZC_ASSIGN(TraceKernels fresh, create_kernels(variant, {.host = host}));
    ZC_TRY(trace_queue(fresh, kRun));  // some drivers compile only now
    made.emplace_back(variant, std::move(fresh));
    return place;
  };
  const auto measure = [&](std::span<const TraceVariant> variants) -> Result<std::vector<double>> {
    std::vector<double> best_ms;
    if (elapsed_ms() > budget_ms) {
      complete = false;
      return best_ms;
    }
    std::vector<std::size_t> places;
    for (const TraceVariant& variant : variants) {
      ZC_ASSIGN(const std::size_t place, make(variant));
      places.push_back(place);
    }
    // In turn, so that whatever else the machine does hits all alike; it only ever adds.
    best_ms.assign(places.size(), INFINITY);
    for (int round = 0; round < kRounds; ++round) {
      for (std::size_t i = 0; i < places.size(); ++i) {
        ZC_ASSIGN(const double ms, trace_queue(made[places[i]].second, rays));
        best_ms[i] = std::min(best_ms[i], ms);
      }
    }
    return best_ms;
  };
  ZC_ASSIGN(const TraceVariant chosen, zc::choose_trace_variant(trace_limits(device_, options_), measure));
  if (chosen != options_.trace) {  // what else reads pages, reads them the same way
    options_.trace = chosen;
    kernels_proxies_.reset();
    kernels_host_.reset();
    any_hit_proxies_.reset();
    any_hit_host_.reset();
    resolve_proxies_ = {};
    resolve_host_ = {};
    ZC_TRY(create_pipelines());
  }
  ZC_ASSIGN(const std::size_t place, make(chosen));
  in_use = std::move(made[place].second);
  return complete;
}

Result<std::vector<TracedHit>> Renderer::trace(const RenderCamera& camera, std::span<const gpu::RayTask> rays,
                                               const TraceOptions& options, double* milliseconds) {
  ZC_CHECK(!rays.empty() && rays.size_bytes() <= rays_.bytes());
  ZC_TRY(create_resolve(options.host));
  ZC_ASSIGN(const TraceKernels* kernels, this->kernels(options));
  write_frame(camera);
  std::memcpy(readback_.mapped().data(), rays.data(), rays.size_bytes());
  ZC_TRY(device_.run([&](VkCommandBuffer c) {
    const VkBufferCopy queue{0, 0, rays.size_bytes()};
    vkCmdCopyBuffer(c, readback_.handle(), rays_.handle(), 1, &queue);
    after_transfer(c);
  }));
  ZC_ASSIGN(const double ms, trace_queue(*kernels, static_cast<std::uint32_t>(rays.size())));
  ZC_TRY(device_.run([&](VkCommandBuffer c) {
    dispatch_indirect(c, options.host ? resolve_host_ : resolve_proxies_, offsetof(gpu::Counters, trace_groups_x));
    const VkBufferCopy back{0, 0, rays.size() * sizeof(gpu::HitRecord)};
    vkCmdCopyBuffer(c, hits_.handle(), readback_.handle(), 1, &back);
    const VkBufferCopy counted{0, 0, sizeof(gpu::Counters)};
    vkCmdCopyBuffer(c, counters_.handle(), counters_readback_.handle(), 1, &counted);
    after_transfer(c);
  }));
  if (milliseconds != nullptr) *milliseconds = ms;
  std::vector<TracedHit> hits(rays.size());
  for (std::size_t i = 0; i < hits.size(); ++i) {
    gpu::ResolvedHit hit;
    std::memcpy(&hit, readback_.mapped().data() + i * sizeof hit, sizeof hit);
    hits[i] = {hit.t, hit.page_word, hit.triangle};
  }
  return hits;
}

}  // namespace zc
