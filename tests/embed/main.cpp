// SPDX-License-Identifier: Apache-2.0
// A host that is not zonecast's: its own Vulkan device and G-buffer (gbuffer.comp.glsl), its own sky
// (adapter/sky.glsl), a world paged under a cap, two frames in flight, and a picture that it checks. Usage: embed WORLD
// EYE_X EYE_Y EYE_Z FORWARD_X FORWARD_Y OUT.ppm
#include <array>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <glm/geometric.hpp>
#include <vector>

#include "check_picture.h"
#include "gbuffer.h"
#include "march_screen.h"
#include "runtime/device/commands.h"
#include "runtime/device/program.h"
#include "runtime/frame_data.h"
#include "runtime/reflections.h"
#include "shade_hits.h"
#include "streamer/open_source.h"
#include "streamer/streamer.h"

using namespace zc;

namespace {

constexpr std::uint32_t kWidth = 320, kHeight = 240, kFrames = 4, kInFlight = 2;

void must(VkResult result) {
  if (result != VK_SUCCESS) std::exit((std::fprintf(stderr, "Vulkan refused: %d\n", result), 1));
}
template <class T>
T must(Result<T> result) {
  if (!result.ok()) std::exit((std::fprintf(stderr, "%s\n", result.error().describe().c_str()), 1));
  if constexpr (!std::is_void_v<T>) return std::move(result).value();
}

struct Vulkan {
  VkInstance instance;
  HostDevice host;
  VkCommandPool pool;
};

Vulkan make_vulkan() {
  Vulkan v{};
  VkApplicationInfo app{VK_STRUCTURE_TYPE_APPLICATION_INFO, nullptr, "embed", 0, nullptr, 0, VK_API_VERSION_1_2};
  VkInstanceCreateInfo instance{VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO, nullptr, 0, &app, 0, nullptr, 0, nullptr};
  must(vkCreateInstance(&instance, nullptr, &v.instance));
  std::uint32_t one = 1;
  if (vkEnumeratePhysicalDevices(v.instance, &one, &v.host.physical) < 0 || one == 0) std::exit(1);
  const float priority = 1;  // family 0 computes on every device that this test runs on; adopt() checks it
  VkDeviceQueueCreateInfo queue{VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO, nullptr, 0, 0, 1, &priority};
  VkDeviceCreateInfo device{
      VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO, nullptr, 0, 1, &queue, 0, nullptr, 0, nullptr, nullptr};
  must(vkCreateDevice(v.host.physical, &device, nullptr, &v.host.device));
  vkGetDeviceQueue(v.host.device, 0, 0, &v.host.queue);
  VkCommandPoolCreateInfo pool{VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO, nullptr, 0, 0};
  must(vkCreateCommandPool(v.host.device, &pool, nullptr, &v.pool));
  return v;
}

Image make_image(Device& device, VkFormat format) {
  constexpr auto usage = VK_IMAGE_USAGE_STORAGE_BIT | VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT;
  return must(Image::create(device, kWidth, kHeight, format, usage, VK_IMAGE_ASPECT_COLOR_BIT));
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 8) return 2;
  const Vulkan v = make_vulkan();
  {
    const auto device = must(Device::adopt(v.host));
    const auto source = must(open_source(argv[1]));
    ZoneSet zones(*device, {.frames_in_flight = kInFlight, .staging_bytes = 4U << 20U});
    StreamerOptions paging;
    paging.cap_bytes = 16U << 20U;
    const auto streamer = must(Streamer::open(*source, paging, zones));
    const IndexView world = streamer->index();
    std::vector<gpu::MaterialEntry> materials;
    for (const MaterialRecord& m : world.materials)
      materials.push_back({m.base_color[0], m.base_color[1], m.base_color[2], m.roughness, m.metallic, m.flags, 0, 0});
    ReflectionsOptions options;
    options.width = kWidth, options.height = kHeight, options.frames_in_flight = kInFlight, options.statistics = true;
    options.adapted_shaders = {{"march_screen", march_screen}, {"shade_hits", shade_hits}};
    const auto reflections = must(Reflections::create(*device, zones, materials, options));
    HostFrame frame;
    const glm::dvec3 eye(std::atof(argv[2]), std::atof(argv[3]), std::atof(argv[4]));
    place_eye(frame.camera, eye, world.header.anchor, world.step_m());
    // Down by 20 degrees, so that mirrored rays leave the screen.
    frame.camera.forward = glm::normalize(glm::vec3(std::atof(argv[5]), std::atof(argv[6]), -0.364));
    frame.camera.right = glm::normalize(glm::cross(frame.camera.forward, glm::vec3(0, 0, 1)));
    frame.camera.up = glm::cross(frame.camera.right, frame.camera.forward);
    const Image depth = make_image(*device, VK_FORMAT_R32_SFLOAT);
    const Image surface = make_image(*device, VK_FORMAT_R32G32B32A32_UINT);
    const Image irradiance = make_image(*device, VK_FORMAT_R16G16B16A16_SFLOAT);
    const Image out = make_image(*device, VK_FORMAT_R16G16B16A16_SFLOAT);
    frame.depth = depth.view(), frame.surface = surface.view(), frame.irradiance = irradiance.view();
    const auto gbuffer_pass = must(Program::create_compute(*device, "gbuffer", gbuffer, {}));
    gpu::FrameData data{};
    fill_frame_data(frame.camera, frame.sun, kWidth, kHeight, data);
    const Buffer uniform =
        must(Buffer::create(*device, sizeof(data), VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT, MemoryUse::kUpload));
    std::memcpy(uniform.mapped().data(), &data, sizeof(data));
    const Buffer picture =
        must(Buffer::create(*device, kWidth * kHeight * 8, VK_BUFFER_USAGE_TRANSFER_DST_BIT, MemoryUse::kReadback));
    BindingTable table;
    table.set_buffer(0, uniform.handle());
    table.set_image(1, depth.view(), VK_IMAGE_LAYOUT_GENERAL);
    table.set_image(2, surface.view(), VK_IMAGE_LAYOUT_GENERAL);
    table.set_image(3, irradiance.view(), VK_IMAGE_LAYOUT_GENERAL);
    std::array<VkCommandBuffer, kFrames> commands{};
    VkCommandBufferAllocateInfo allocate{VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO, nullptr, v.pool,
                                         VK_COMMAND_BUFFER_LEVEL_PRIMARY, kFrames};
    must(vkAllocateCommandBuffers(v.host.device, &allocate, commands.data()));
    std::array<VkFence, kFrames> fences{};
    const View view{eye};
    for (std::uint32_t f = 0; f < kFrames; ++f) {
      VkFenceCreateInfo fence{VK_STRUCTURE_TYPE_FENCE_CREATE_INFO};
      must(vkCreateFence(v.host.device, &fence, nullptr, &fences[f]));
      if (f >= kInFlight) must(vkWaitForFences(v.host.device, 1, &fences[f - kInFlight], VK_TRUE, UINT64_MAX));
      must(streamer->advance(std::span(&view, 1), f));
      VkCommandBuffer c = commands[f];
      VkCommandBufferBeginInfo begin{VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO};
      must(vkBeginCommandBuffer(c, &begin));
      zones.record_transfers(c);
      for (const Image* image : {&depth, &surface, &irradiance, &out})
        change_layout(c, *image, VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_GENERAL);
      gbuffer_pass->bind(c, table, f % kInFlight);
      vkCmdDispatch(c, kWidth / 8, kHeight / 8, 1);
      for (const Image* image : {&depth, &surface, &irradiance})
        change_layout(c, *image, VK_IMAGE_LAYOUT_GENERAL, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL);
      must(reflections->record(c, frame, out.view()));
      const VkBufferImageCopy all{0, 0, 0, {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1}, {}, {kWidth, kHeight, 1}};
      vkCmdCopyImageToBuffer(c, out.handle(), VK_IMAGE_LAYOUT_GENERAL, picture.handle(), 1, &all);
      barrier_after_transfer(c);
      must(vkEndCommandBuffer(c));
      VkSubmitInfo submit{VK_STRUCTURE_TYPE_SUBMIT_INFO, nullptr, 0, nullptr, nullptr, 1, &c, 0, nullptr};
      must(vkQueueSubmit(v.host.queue, 1, &submit, fences[f]));
    }
    must(vkQueueWaitIdle(v.host.queue));
    const bool right = check_picture(picture.mapped(), kWidth, kHeight, must(reflections->report()), argv[7]);
    for (VkFence fence : fences) vkDestroyFence(v.host.device, fence, nullptr);
    if (!right) std::exit(1);
  }
  vkDestroyCommandPool(v.host.device, v.pool, nullptr);
  vkDestroyDevice(v.host.device, nullptr);
  vkDestroyInstance(v.instance, nullptr);
  return 0;
}
