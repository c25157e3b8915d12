// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>
#include <spng.h>
#include <stdlib.h>

#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "base/file.h"
#include "replay/image/png_file.h"

namespace zc {
namespace {

class PngFile : public testing::Test {
 protected:
  void SetUp() override {
    std::string pattern = (std::filesystem::temp_directory_path() / "zonecast-png-XXXXXX").string();
    ASSERT_NE(mkdtemp(pattern.data()), nullptr);
    folder_ = pattern;
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  std::filesystem::path folder_;
};

Picture gradient(std::uint32_t width, std::uint32_t height) {
  Picture picture{width, height, {}};
  for (std::uint32_t y = 0; y < height; ++y) {
    for (std::uint32_t x = 0; x < width; ++x) {
      for (const std::uint32_t v : {x * 7, y * 11, x * y, 255U}) picture.rgba.push_back(static_cast<std::uint8_t>(v));
    }
  }
  return picture;
}

Picture plain(std::uint32_t width, std::uint32_t height, std::uint8_t value) {
  return {width, height, std::vector<std::uint8_t>(std::size_t{4} * width * height, value)};
}

std::uint8_t red_at(const Picture& picture, std::uint32_t x, std::uint32_t y) {
  return picture.rgba[(std::size_t{y} * picture.width + x) * 4];
}

TEST_F(PngFile, ColoursComeBackAsTheyWereWritten) {
  const Picture picture = gradient(37, 23);
  const std::filesystem::path file = folder_ / "picture.png";
  ASSERT_TRUE(write_png(file, picture).ok());
  const auto bytes = read_file(file, 1 << 20);
  ASSERT_TRUE(bytes.ok());
  const std::unique_ptr<spng_ctx, decltype(&spng_ctx_free)> context(spng_ctx_new(0), &spng_ctx_free);
  ASSERT_EQ(spng_set_png_buffer(context.get(), bytes->data(), bytes->size()), 0);
  spng_ihdr header{};
  ASSERT_EQ(spng_get_ihdr(context.get(), &header), 0);
  EXPECT_EQ(header.width, 37U);
  EXPECT_EQ(header.height, 23U);
  EXPECT_EQ(header.color_type, SPNG_COLOR_TYPE_TRUECOLOR);
  std::size_t size = 0;
  ASSERT_EQ(spng_decoded_image_size(context.get(), SPNG_FMT_RGBA8, &size), 0);
  std::vector<std::uint8_t> pixels(size);
  ASSERT_EQ(spng_decode_image(context.get(), pixels.data(), size, SPNG_FMT_RGBA8, 0), 0);
  EXPECT_EQ(pixels, picture.rgba);
}

TEST_F(PngFile, SamePictureGivesSameBytesAndNothingElseIsLeft) {
  ASSERT_TRUE(write_png(folder_ / "a.png", gradient(64, 64)).ok());
  ASSERT_TRUE(write_png(folder_ / "b.png", gradient(64, 64)).ok());
  EXPECT_EQ(read_file(folder_ / "a.png", 1 << 20).value(), read_file(folder_ / "b.png", 1 << 20).value());
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder_), {}), 2);
}

TEST_F(PngFile, AFolderThatIsMissingIsNamed) {
  const std::filesystem::path file = folder_ / "none" / "a.png";
  const Status status = write_png(file, gradient(8, 8));
  ASSERT_FALSE(status.ok());
  EXPECT_EQ(status.error().path, file.string());
}

TEST_F(PngFile, OnlyWhatThisProgramWroteIsRemoved) {
  const std::filesystem::path pictures = folder_ / "frames";
  EXPECT_TRUE(remove_written_pngs(pictures).ok());  // none there
  ASSERT_TRUE(make_folder(pictures).ok());
  const auto write = [&](const std::string& name, std::span<const std::byte> bytes) {
    ASSERT_TRUE(write_file(pictures / name, bytes).ok());
  };
  ASSERT_TRUE(write_png(pictures / "000000.png", gradient(64, 64)).ok());
  ASSERT_TRUE(write_png(pictures / "plaza.png", gradient(8, 8)).ok());
  const std::vector<std::byte> ours = read_file(pictures / "plaza.png", 1 << 20).value();
  write("plaza.txt", ours);
  write("empty.png", {});
  std::vector<std::byte> others = ours;
  others[33 + 8 + 9] = std::byte{'Z'};  // the writer's name
  write("others.png", others);
  ASSERT_TRUE(make_folder(pictures / "folder.png").ok());
  ASSERT_TRUE(remove_written_pngs(pictures).ok());
  EXPECT_FALSE(std::filesystem::exists(pictures / "000000.png"));
  EXPECT_FALSE(std::filesystem::exists(pictures / "plaza.png"));
  for (const char* kept : {"plaza.txt", "empty.png", "others.png", "folder.png"})
    EXPECT_TRUE(std::filesystem::exists(pictures / kept)) << kept;

  ASSERT_TRUE(make_folder(folder_ / "alone").ok());
  ASSERT_TRUE(write_png(folder_ / "alone" / "a.png", gradient(8, 8)).ok());
  ASSERT_TRUE(remove_written_pngs(folder_ / "alone").ok());
  EXPECT_FALSE(std::filesystem::exists(folder_ / "alone"));
}

TEST(ScaleDown, AveragesBoxesAndKeepsTheShape) {
  Picture picture = plain(4, 2, 0);
  for (std::size_t i = 0; i < 4; ++i) picture.rgba[i] = 200;  // the first pixel of a 2 × 2 box
  const Picture small = scale_down(picture, 2);
  EXPECT_EQ(small.width, 2U);
  EXPECT_EQ(small.height, 1U);
  EXPECT_EQ(red_at(small, 0, 0), 50);
  EXPECT_EQ(red_at(small, 1, 0), 0);
}

TEST(ScaleDown, NeverScalesUpAndNeverVanishes) {
  EXPECT_EQ(scale_down(gradient(8, 8), 100).rgba, gradient(8, 8).rgba);
  const Picture strip = scale_down(gradient(100, 2), 10);
  EXPECT_EQ(strip.width, 10U);
  EXPECT_EQ(strip.height, 1U);
}

TEST(ContactSheet, LaysTilesOutByRows) {
  const Picture sheet = make_contact_sheet({plain(8, 4, 10), plain(8, 4, 20), plain(8, 4, 30)}, 2, 8);
  EXPECT_EQ(sheet.width, 2U * (8 + 4) + 4);
  EXPECT_EQ(sheet.height, 2U * (4 + 4) + 4);
  EXPECT_EQ(red_at(sheet, 0, 0), 255);
  EXPECT_EQ(red_at(sheet, 4, 4), 10);
  EXPECT_EQ(red_at(sheet, 4 + 12, 4), 20);
  EXPECT_EQ(red_at(sheet, 4, 4 + 8), 30);
  EXPECT_EQ(red_at(sheet, 4 + 12, 4 + 8), 255);  // no fourth
}

TEST(ContactSheet, OfFewPicturesIsNoWiderThanThey) {
  const Picture sheet = make_contact_sheet({plain(8, 4, 10)}, 3, 8);
  EXPECT_EQ(sheet.width, 8U + 2 * 4);
  EXPECT_EQ(sheet.height, 4U + 2 * 4);
}

}  // namespace
}  // namespace zc
