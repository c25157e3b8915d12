// SPDX-License-Identifier: GPL-3.0-or-later
// The promises of Reflections to its host, over a real world: what is compiled, scheduled and reported, and that
// neither the way that pixels are classified nor the way that pages travel shows in a picture.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <vector>

#include "runtime/device/shader_interface.h"
#include "runtime/passes/pass_list.h"
#include "spirv/passes.h"
#include "tests/numerics/rendered_world.h"
#include "tests/unit/baker/test_city.h"

namespace zc {
namespace {

// A mirror that faces a red wall and, to its sides, the sky.
Scene mirror_scene() {
  test::SceneMaker maker;
  maker.scene.materials.push_back({"mirror", {1, 1, 1}, 0.01F, 1});
  maker.scene.materials.push_back({"red", {0.7F, 0.05F, 0.05F}, 1, 0});
  maker.quad({-30, 10, 0}, {30, 10, 0}, {30, 10, 12}, {-30, 10, 12}, 4);
  maker.object(ObjectKind::kObject);
  maker.quad({10, -10, 0}, {-10, -10, 0}, {-10, -10, 12}, {10, -10, 12}, 5);
  maker.object(ObjectKind::kObject);
  return std::move(maker.scene);
}

HostOptions small_picture() {
  HostOptions options;
  options.width = 150;  // no multiple of a tile
  options.height = 107;
  return options;
}

class ReflectionsOfAMirror : public testing::Test {
 protected:
  void SetUp() override {
    const Status opened = world_.open(mirror_scene(), {}, small_picture());
    ASSERT_TRUE(opened.ok()) << opened.error().describe();
  }
  FrameResult render() {
    auto frame = world_.render(world_.camera({0.1, -5.2, 6.3}, {1, 0, 0}, {0, 0, 1}, {0, 1, 0}));
    EXPECT_TRUE(frame.ok());
    return *frame;
  }
  std::vector<std::byte> picture() {
    render();
    const auto pixels = world_.renderer().pixels();
    return {pixels.begin(), pixels.end()};
  }
  test::RenderedWorld world_;
};

TEST(Passes, BindAtMostSixteenStorageBuffers) {
  for (const ListedPass& listed : all_passes()) {
    const auto shader = reflect_shader(listed.spirv());
    ASSERT_TRUE(shader.ok()) << listed.name;
    EXPECT_FALSE(shader->bindings.empty()) << listed.name;
    EXPECT_LE(std::ranges::count(shader->bindings, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, &ShaderInterface::Binding::type),
              16)
        << listed.name;
  }
}

TEST(Passes, CodeThatIsNoShaderIsRefused) {
  const std::array<std::uint32_t, 6> words = {0x07230203, 0x10000, 0, 8, 0, 0xFFFFFFFF};
  EXPECT_FALSE(reflect_shader(words).ok());
  EXPECT_FALSE(reflect_shader(std::span(words).first(2)).ok());
}

TEST_F(ReflectionsOfAMirror, OtherSettingsCompileOnlyWhatTheyChange) {
  HostOptions options = small_picture();
  Reflections& reflections = *world_.renderer().reflections();
  const std::vector<std::byte> with_screen = picture();
  const std::size_t first = reflections.program_count();

  options.roughness_cut = 0.2F;  // what frames are told, not what is compiled
  options.screen_steps = 64;
  ASSERT_TRUE(world_.renderer().reconfigure(options).ok());
  render();
  EXPECT_EQ(reflections.program_count(), first);

  options = small_picture();
  options.reflections = ReflectionMode::kProxy;
  ASSERT_TRUE(world_.renderer().reconfigure(options).ok());
  EXPECT_EQ(render().counters.rays_screen, 0U);
  EXPECT_EQ(reflections.program_count(), first + 1);  // the march alone

  ASSERT_TRUE(world_.renderer().reconfigure(small_picture()).ok());
  EXPECT_EQ(picture(), with_screen);
  EXPECT_EQ(reflections.program_count(), first + 1);
  EXPECT_EQ(&reflections, world_.renderer().reflections());
}

TEST_F(ReflectionsOfAMirror, AThreadAPixelClassifiesAsATileDoes) {
  HostOptions options = small_picture();
  options.thread_per_pixel = false;
  ASSERT_TRUE(world_.renderer().reconfigure(options).ok());
  const FrameResult tiles = render();
  const std::vector<std::byte> by_tiles = picture();
  options.thread_per_pixel = true;
  ASSERT_TRUE(world_.renderer().reconfigure(options).ok());
  const FrameResult pixels = render();
  EXPECT_GT(tiles.counters.pixel_count, 1000U);
  EXPECT_EQ(pixels.counters.pixel_count, tiles.counters.pixel_count);
  EXPECT_EQ(pixels.counters.rays_proxy, tiles.counters.rays_proxy);
  EXPECT_EQ(picture(), by_tiles);
  EXPECT_EQ(world_.device().validation_messages(), 0U);
}

TEST_F(ReflectionsOfAMirror, WhatIsLeftOutIsNamedAndNotScheduled) {
  HostOptions options = small_picture();
  EXPECT_TRUE(world_.renderer().left_out().empty());
  options.reflections = ReflectionMode::kProxy;
  ASSERT_TRUE(world_.renderer().reconfigure(options).ok());
  ASSERT_EQ(world_.renderer().left_out().size(), 1U);
  EXPECT_EQ(world_.renderer().left_out()[0].passes, "hiz");
  EXPECT_EQ(render().pass_ms[1], 0);

  options.roughness_cut = 0.005F;  // nothing is as smooth
  ASSERT_TRUE(world_.renderer().reconfigure(options).ok());
  EXPECT_EQ(render().counters.pixel_count, 0U);
  std::size_t passes = 0;
  for (const LeftOutPass& left : world_.renderer().left_out())
    passes += 1 + static_cast<std::size_t>(std::ranges::count(left.passes, ','));
  EXPECT_EQ(passes, all_passes().size() - 1);  // pixels are still cleared

  options.leave_nothing_out = true;
  ASSERT_TRUE(world_.renderer().reconfigure(options).ok());
  EXPECT_EQ(world_.renderer().left_out().size(), 1U);
}

TEST_F(ReflectionsOfAMirror, AFrameWithoutItsImagesIsRefused) {
  EXPECT_FALSE(world_.renderer().reflections()->record(VK_NULL_HANDLE, {}, VK_NULL_HANDLE).ok());
}

// Pages that travel through a ring of staging memory, one frame after the other, lie where they would have lain.
TEST(TransfersTest, AreAsMemcpyAndMemmoveInTheOrderOfTheCalls) {
  DeviceOptions options;
  options.validation = true;
  const auto device = Device::create(options);
  ASSERT_TRUE(device.ok());
  constexpr std::uint64_t kBytes = 64U << 10U;
  constexpr VkBufferUsageFlags usage = VK_BUFFER_USAGE_TRANSFER_SRC_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT;
  const auto target = Buffer::create(**device, kBytes, usage, MemoryUse::kReadback);
  ASSERT_TRUE(target.ok());
  std::vector<std::byte> expected(kBytes);
  std::memset(target->mapped().data(), 0, kBytes);
  Transfers transfers(**device);
  ASSERT_TRUE(transfers.create(8U << 10U, 2).ok());
  std::uint32_t random = 1;
  const auto next = [&](std::uint32_t below) {
    random = random * 1664525U + 1013904223U;
    return (random >> 8U) % below;
  };
  for (int frame = 0; frame < 200; ++frame) {
    for (std::uint32_t i = next(6); i > 0; --i) {
      const std::uint64_t bytes = 4 * (1 + next(600));
      const std::uint64_t to = 4 * next(static_cast<std::uint32_t>((kBytes - bytes) / 4));
      if (next(3) == 0) {
        const std::uint64_t from = std::min<std::uint64_t>(to + 4 * next(300), kBytes - bytes);
        ASSERT_TRUE(transfers.move(*target, from, to, bytes).ok());
        std::memmove(expected.data() + to, expected.data() + from, bytes);
      } else {
        std::vector<std::byte> page(bytes);
        for (std::byte& b : page) b = static_cast<std::byte>(next(256));
        ASSERT_TRUE(transfers.write(*target, to, page).ok());
        std::memcpy(expected.data() + to, page.data(), bytes);
      }
    }
    ASSERT_TRUE((*device)->run([&](VkCommandBuffer c) { transfers.record(c); }).ok());
    ASSERT_EQ(std::memcmp(target->mapped().data(), expected.data(), kBytes), 0) << "frame " << frame;
  }
  EXPECT_GT(transfers.waits(), 0U);  // the ring was too small at times, which does not show
  EXPECT_EQ((*device)->validation_messages(), 0U);
}

class PipelineCacheTest : public testing::Test {
 protected:
  std::filesystem::path file_ = std::filesystem::temp_directory_path() / "zonecast-pipeline-cache-test" / "pipelines";
  void TearDown() override { std::filesystem::remove_all(file_.parent_path()); }
  void compile() {
    DeviceOptions options;
    options.pipeline_cache = file_;
    const auto device = Device::create(options);
    ASSERT_TRUE(device.ok()) << device.error().describe();
    EXPECT_TRUE(Program::create_compute(**device, "size_dispatch", shader::size_dispatch(), {}).ok());
  }
};

TEST_F(PipelineCacheTest, IsKeptInAFileAndADamagedFileIsAsGoodAsNone) {
  compile();
  ASSERT_TRUE(std::filesystem::exists(file_));
  const auto bytes = std::filesystem::file_size(file_);
  compile();
  for (const std::uint64_t size : {std::uint64_t{0}, std::uint64_t{7}, bytes - 1}) {
    std::filesystem::resize_file(file_, size);
    compile();
    EXPECT_EQ(std::filesystem::file_size(file_), bytes);
  }
  std::fstream file(file_, std::ios::in | std::ios::out | std::ios::binary);
  file.seekp(static_cast<std::streamoff>(bytes / 2));
  file.put('\x5A');
  file.close();
  compile();
}

}  // namespace
}  // namespace zc
