// SPDX-License-Identifier: Apache-2.0
// Renderer: what is made once. The frame itself is in renderer.cpp.
#include <algorithm>
#include <array>
#include <string>

#include "runtime/renderer.h"
#include "spirv/shader_code.h"

namespace zc {
namespace {

constexpr VkFormat kSurfaceFormat = VK_FORMAT_R32G32B32A32_UINT;
constexpr VkFormat kDepthFormat = VK_FORMAT_D32_SFLOAT;
constexpr VkFormat kOverlayFormat = VK_FORMAT_R8G8B8A8_UNORM;

VkAttachmentDescription attachment(VkFormat format, VkAttachmentLoadOp load, VkImageLayout from, VkImageLayout to) {
  VkAttachmentDescription a{};
  a.format = format;
  a.samples = VK_SAMPLE_COUNT_1_BIT;
  a.loadOp = load;
  a.storeOp = VK_ATTACHMENT_STORE_OP_STORE;
  a.stencilLoadOp = VK_ATTACHMENT_LOAD_OP_DONT_CARE;
  a.stencilStoreOp = VK_ATTACHMENT_STORE_OP_DONT_CARE;
  a.initialLayout = from;
  a.finalLayout = to;
  return a;
}

// `attachments`: colours first, depth last. Everything before and after is ordered against the pass.
Result<VkRenderPass> make_render_pass(const Device& device, std::span<const VkAttachmentDescription> attachments) {
  std::vector<VkAttachmentReference> colors;
  const auto depth_index = static_cast<std::uint32_t>(attachments.size() - 1);
  for (std::uint32_t i = 0; i < depth_index; ++i) colors.push_back({i, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL});
  const VkAttachmentReference depth{depth_index, VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL};
  VkSubpassDescription subpass{};
  subpass.pipelineBindPoint = VK_PIPELINE_BIND_POINT_GRAPHICS;
  subpass.colorAttachmentCount = static_cast<std::uint32_t>(colors.size());
  subpass.pColorAttachments = colors.data();
  subpass.pDepthStencilAttachment = &depth;
  constexpr VkAccessFlags all = VK_ACCESS_MEMORY_READ_BIT | VK_ACCESS_MEMORY_WRITE_BIT;
  const std::array dependencies = {VkSubpassDependency{VK_SUBPASS_EXTERNAL, 0, VK_PIPELINE_STAGE_ALL_COMMANDS_BIT,
                                                       VK_PIPELINE_STAGE_ALL_GRAPHICS_BIT, all, all, 0},
                                   VkSubpassDependency{0, VK_SUBPASS_EXTERNAL, VK_PIPELINE_STAGE_ALL_GRAPHICS_BIT,
                                                       VK_PIPELINE_STAGE_ALL_COMMANDS_BIT, all, all, 0}};
  VkRenderPassCreateInfo info{VK_STRUCTURE_TYPE_RENDER_PASS_CREATE_INFO};
  info.attachmentCount = static_cast<std::uint32_t>(attachments.size());
  info.pAttachments = attachments.data();
  info.subpassCount = 1;
  info.pSubpasses = &subpass;
  info.dependencyCount = static_cast<std::uint32_t>(dependencies.size());
  info.pDependencies = dependencies.data();
  VkRenderPass pass = VK_NULL_HANDLE;
  ZC_VK(vkCreateRenderPass(device.handle(), &info, nullptr, &pass));
  return pass;
}

Result<VkFramebuffer> make_framebuffer(const Device& device, VkRenderPass pass, std::span<const VkImageView> views,
                                       std::uint32_t width, std::uint32_t height) {
  VkFramebufferCreateInfo info{VK_STRUCTURE_TYPE_FRAMEBUFFER_CREATE_INFO};
  info.renderPass = pass;
  info.attachmentCount = static_cast<std::uint32_t>(views.size());
  info.pAttachments = views.data();
  info.width = width;
  info.height = height;
  info.layers = 1;
  VkFramebuffer framebuffer = VK_NULL_HANDLE;
  ZC_VK(vkCreateFramebuffer(device.handle(), &info, nullptr, &framebuffer));
  return framebuffer;
}

}  // namespace

TraceLimits trace_limits(const Device& device, const RendererOptions& options) {
  // A level leaves at most one entry behind, and the last none.
  return {device.subgroup_size(), device.limits().maxComputeSharedMemorySize,
          options.page_depth + top_level_depth_bound(options.max_zones), options.pools_as_texels,
          options.step_limit > 0 ? options.step_limit : step_limit(device.name())};
}

Result<std::unique_ptr<Renderer>> Renderer::create(Device& device, const ZoneSet& proxies, const ZoneSet& host,
                                                   std::span<const gpu::MaterialEntry> materials,
                                                   const RendererOptions& options) {
  std::unique_ptr<Renderer> renderer(new Renderer(device, proxies, host, options));
  renderer->options_.trace = nearest_fit(options.trace, trace_limits(device, options));
  ZC_TRY(renderer->layout_.create());
  ZC_TRY(renderer->create_buffers(materials));
  ZC_TRY(renderer->create_targets());
  ZC_TRY(renderer->create_pipelines());
  ZC_TRY(renderer->kernels({.host = options.reflections == ReflectionMode::kFull}));
  return renderer;
}

Renderer::~Renderer() {
  vkDestroyQueryPool(device_.handle(), queries_, nullptr);
  vkDestroyFramebuffer(device_.handle(), gbuffer_target_, nullptr);
  vkDestroyFramebuffer(device_.handle(), overlay_target_, nullptr);
  vkDestroyRenderPass(device_.handle(), gbuffer_pass_, nullptr);
  vkDestroyRenderPass(device_.handle(), overlay_pass_, nullptr);
}

Status Renderer::create_buffers(std::span<const gpu::MaterialEntry> materials) {
  const VkDeviceSize pixels = VkDeviceSize{options_.width} * options_.height;
  const auto make = [&](Buffer& buffer, VkDeviceSize bytes, VkBufferUsageFlags usage, MemoryUse use) -> Status {
    if ((usage & VK_BUFFER_USAGE_STORAGE_BUFFER_BIT) != 0 && bytes > device_.limits().maxStorageBufferRange)
      return Error{ErrorCode::kDevice, "a picture of " + std::to_string(options_.width) + "x" +
                                           std::to_string(options_.height) + " takes a buffer of " +
                                           std::to_string(bytes) + " bytes, more than " + device_.name() + " binds (" +
                                           std::to_string(device_.limits().maxStorageBufferRange) + ")"};
    ZC_ASSIGN(buffer, Buffer::create(device_, bytes, usage, use));
    return {};
  };
  constexpr VkBufferUsageFlags storage =
      VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_TRANSFER_SRC_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT;
  ZC_TRY(make(frame_buffer_, sizeof(gpu::FrameData), VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT, MemoryUse::kUpload));
  ZC_TRY(make(materials_, std::max<VkDeviceSize>(1, materials.size()) * sizeof(gpu::MaterialEntry), storage,
              MemoryUse::kUpload));
  std::ranges::copy(std::as_bytes(materials), materials_.mapped().begin());

  VkDeviceSize hiz_floats = 0;
  std::uint32_t width = options_.width;
  std::uint32_t height = options_.height;
  std::uint32_t level = 0;
  for (; level < gpu::kHizLevels; ++level) {
    frame_.hiz_offset[level] = {static_cast<std::uint32_t>(hiz_floats), width, height, 0};
    hiz_floats += VkDeviceSize{width} * height;
    if (width == 1 && height == 1) break;
    width = (width + 1) / 2;
    height = (height + 1) / 2;
  }
  frame_.size = {options_.width, options_.height, std::min(level + 1, gpu::kHizLevels), options_.screen_steps};

  ZC_TRY(make(hiz_, hiz_floats * 4, storage, MemoryUse::kDevice));
  ZC_TRY(make(lit_, pixels * 8, storage, MemoryUse::kDevice));
  ZC_TRY(make(reflection_, pixels * 8, storage, MemoryUse::kDevice));
  ZC_TRY(make(provenance_, pixels * 4, storage, MemoryUse::kDevice));
  ZC_TRY(make(pixel_list_, pixels * 4, storage, MemoryUse::kDevice));
  ZC_TRY(make(rays_, pixels * sizeof(gpu::RayTask), storage | VK_BUFFER_USAGE_UNIFORM_TEXEL_BUFFER_BIT,
              MemoryUse::kDevice));
  ZC_ASSIGN(ray_texels_, BufferView::create(device_, rays_, VK_FORMAT_R32G32B32A32_UINT));
  ZC_TRY(make(hits_, pixels * sizeof(gpu::HitRecord), storage, MemoryUse::kDevice));
  ZC_TRY(make(fallback_rays_, (pixels / 8 + 1) * sizeof(gpu::FallbackRays), storage, MemoryUse::kDevice));
  ZC_TRY(make(counters_, sizeof(gpu::Counters), storage | VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT, MemoryUse::kDevice));
  ZC_TRY(make(output_, pixels * 4, storage, MemoryUse::kDevice));
  // Large enough for a picture and for the ray queue of trace().
  constexpr VkBufferUsageFlags copied = VK_BUFFER_USAGE_TRANSFER_SRC_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT;
  ZC_TRY(make(readback_, pixels * sizeof(gpu::RayTask), copied, MemoryUse::kReadback));
  ZC_TRY(make(counters_readback_, sizeof(gpu::Counters), copied, MemoryUse::kReadback));
  return {};
}

Status Renderer::create_targets() {
  const auto w = options_.width;
  const auto h = options_.height;
  constexpr VkImageUsageFlags color = VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_SAMPLED_BIT;
  constexpr VkImageUsageFlags copied =
      VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT;
  ZC_ASSIGN(surface_, Image::create(device_, w, h, kSurfaceFormat, color, VK_IMAGE_ASPECT_COLOR_BIT));
  ZC_ASSIGN(depth_, Image::create(device_, w, h, kDepthFormat,
                                  VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT | VK_IMAGE_USAGE_SAMPLED_BIT,
                                  VK_IMAGE_ASPECT_DEPTH_BIT));
  ZC_ASSIGN(overlay_, Image::create(device_, w, h, kOverlayFormat, copied, VK_IMAGE_ASPECT_COLOR_BIT));

  constexpr auto read = VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL;
  const std::array gbuffer = {attachment(kSurfaceFormat, VK_ATTACHMENT_LOAD_OP_CLEAR, VK_IMAGE_LAYOUT_UNDEFINED, read),
                              attachment(kDepthFormat, VK_ATTACHMENT_LOAD_OP_CLEAR, VK_IMAGE_LAYOUT_UNDEFINED, read)};
  ZC_ASSIGN(gbuffer_pass_, make_render_pass(device_, gbuffer));
  const std::array overlay = {attachment(kOverlayFormat, VK_ATTACHMENT_LOAD_OP_LOAD,
                                         VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL),
                              attachment(kDepthFormat, VK_ATTACHMENT_LOAD_OP_LOAD, read, read)};
  ZC_ASSIGN(overlay_pass_, make_render_pass(device_, overlay));
  const std::array gbuffer_views = {surface_.view(), depth_.view()};
  ZC_ASSIGN(gbuffer_target_, make_framebuffer(device_, gbuffer_pass_, gbuffer_views, w, h));
  const std::array overlay_views = {overlay_.view(), depth_.view()};
  ZC_ASSIGN(overlay_target_, make_framebuffer(device_, overlay_pass_, overlay_views, w, h));

  VkQueryPoolCreateInfo queries{VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO};
  queries.queryType = VK_QUERY_TYPE_TIMESTAMP;
  queries.queryCount = kPassCount + 1;
  ZC_VK(vkCreateQueryPool(device_.handle(), &queries, nullptr, &queries_));

  layout_.bind_buffer(gpu::kBindFrame, frame_buffer_.handle());
  layout_.bind_buffer(gpu::kBindProxyPool, proxies_.pool().handle());
  layout_.bind_buffer(gpu::kBindProxyZones, proxies_.zones().handle());
  layout_.bind_buffer(gpu::kBindProxyPool4, proxies_.pool().handle());
  layout_.bind_texels(gpu::kBindProxyTexels, proxies_.texels().handle());
  layout_.bind_texels(gpu::kBindProxyTexels4, proxies_.texels4().handle());
  layout_.bind_buffer(gpu::kBindHostPool, host_.pool().handle());
  layout_.bind_buffer(gpu::kBindHostZones, host_.zones().handle());
  layout_.bind_buffer(gpu::kBindHostPool4, host_.pool().handle());
  layout_.bind_texels(gpu::kBindHostTexels, host_.texels().handle());
  layout_.bind_texels(gpu::kBindHostTexels4, host_.texels4().handle());
  layout_.bind_buffer(gpu::kBindMaterials, materials_.handle());
  layout_.bind_buffer(gpu::kBindHiz, hiz_.handle());
  layout_.bind_buffer(gpu::kBindLit, lit_.handle());
  layout_.bind_buffer(gpu::kBindReflection, reflection_.handle());
  layout_.bind_buffer(gpu::kBindProvenance, provenance_.handle());
  layout_.bind_buffer(gpu::kBindPixels, pixel_list_.handle());
  layout_.bind_buffer(gpu::kBindRays, rays_.handle());
  layout_.bind_buffer(gpu::kBindHits, hits_.handle());
  layout_.bind_texels(gpu::kBindRayTexels4, ray_texels_.handle());
  layout_.bind_buffer(gpu::kBindFallbackRays, fallback_rays_.handle());
  layout_.bind_buffer(gpu::kBindCounters, counters_.handle());
  layout_.bind_buffer(gpu::kBindOutput, output_.handle());
  layout_.bind_sampled(gpu::kBindDepth, depth_.view(), read);
  layout_.bind_sampled(gpu::kBindSurface, surface_.view(), read);
  return {};
}

Status Renderer::create_pipelines() {
  PassVariant variant = pass_variant(options_.trace, options_.reflections == ReflectionMode::kFull);
  variant.stack_shared = 0;  // measured for the trace alone
  const auto compute = [&](Pipeline& pipeline, std::span<const std::uint32_t> code, const PassVariant& v) -> Status {
    ZC_ASSIGN(pipeline, Pipeline::create_compute(device_, layout_, code, v));
    return {};
  };
  ZC_TRY(compute(light_, shader::light_surfaces(), variant));
  ZC_TRY(compute(reduce_, shader::reduce_depth(), variant));
  ZC_TRY(compute(classify_, shader::classify_pixels(), variant));
  ZC_TRY(compute(march_, shader::march_screen(), variant));
  ZC_TRY(compute(shade_, shader::shade_hits(), variant));
  ZC_TRY(compute(composite_, shader::composite_frame(), variant));
  ZC_TRY(compute(debug_, shader::show_debug(), variant));

  Pipeline::Graphics zone;
  zone.variant = variant;
  zone.vertex = shader::draw_zone_vert();
  zone.fragment = shader::draw_zone_frag();
  zone.render_pass = gbuffer_pass_;
  zone.width = options_.width;
  zone.height = options_.height;
  ZC_ASSIGN(draw_zone_, Pipeline::create_graphics(device_, layout_, zone));
  Pipeline::Graphics lines = zone;
  lines.vertex = shader::draw_lines_vert();
  lines.fragment = shader::draw_lines_frag();
  lines.render_pass = overlay_pass_;
  lines.topology = VK_PRIMITIVE_TOPOLOGY_LINE_LIST;
  lines.depth_write = false;
  ZC_ASSIGN(draw_lines_, Pipeline::create_graphics(device_, layout_, lines));
  return {};
}

PassVariant Renderer::pass_variant(const TraceVariant& trace, bool host) const {
  PassVariant variant;
  const TraceLimits limits = trace_limits(device_, options_);
  variant.stack_size = static_cast<std::int32_t>(limits.stack_entries);
  variant.step_limit = static_cast<std::int32_t>(limits.steps);
  variant.use_screen = options_.reflections == ReflectionMode::kScreenAndProxy ? 1 : 0;
  variant.trace_host = host ? 1 : 0;
  variant.pool_path = trace.pool_path;
  variant.rays_per_lane = static_cast<std::int32_t>(trace.rays_per_lane);
  variant.check_access = options_.check_access ? 1 : 0;
  variant.stack_shared = trace.stack_shared ? 1 : 0;
  variant.trace_width = trace.width;
  return variant;
}

LayoutKernels Renderer::layout_kernels(bool host) const {
  if (!host && !options_.proxy_kernels.rays.empty()) return options_.proxy_kernels;
  return {shader::trace_packets(), shader::trace_rays(), shader::resolve_hits()};
}

Result<Renderer::TraceKernels> Renderer::create_kernels(const TraceVariant& trace, const TraceOptions& options) const {
  PassVariant variant = pass_variant(trace, options.host);
  variant.any_hit = options.any_hit ? 1 : 0;
  const LayoutKernels code = layout_kernels(options.host);
  TraceKernels kernels;
  ZC_ASSIGN(kernels.size, Pipeline::create_compute(device_, layout_, shader::size_dispatch(), variant));
  ZC_ASSIGN(kernels.rays, Pipeline::create_compute(device_, layout_, code.rays, variant));
  if (trace.rays_per_lane > 0) {
    ZC_ASSIGN(kernels.packets, Pipeline::create_compute(device_, layout_, code.packets, variant));
  }
  return kernels;
}

Result<const Renderer::TraceKernels*> Renderer::kernels(const TraceOptions& options) {
  std::optional<TraceKernels>& closest = options.host ? kernels_host_ : kernels_proxies_;
  std::optional<TraceKernels>& any_hit = options.host ? any_hit_host_ : any_hit_proxies_;
  std::optional<TraceKernels>& made = options.any_hit ? any_hit : closest;
  if (!made) {
    ZC_ASSIGN(made, create_kernels(options_.trace, options));
  }
  return &*made;
}

Status Renderer::create_resolve(bool host) {
  Pipeline& pipeline = host ? resolve_host_ : resolve_proxies_;
  if (pipeline.handle() != VK_NULL_HANDLE) return {};
  ZC_ASSIGN(pipeline, Pipeline::create_compute(device_, layout_, layout_kernels(host).resolve,
                                               pass_variant(options_.trace, host)));
  return {};
}

}  // namespace zc
