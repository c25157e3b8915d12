// SPDX-License-Identifier: GPL-3.0-or-later
// Images by their libraries, and what is refused. The pictures are coded here, by the libraries' own encoders.
#include <gtest/gtest.h>
#include <turbojpeg.h>
#include <webp/encode.h>
#include <zlib.h>
#include <zstd.h>

#include <memory>
#include <random>
#include <string>

#include "baker/import/images/decode_image.h"
#include "tests/unit/baker/import/pictures.h"

namespace zc::test {
namespace {

Bytes jpeg(std::uint32_t width, std::uint32_t height, int flags = 0, int format = TJPF_RGB) {
  const std::vector<std::uint8_t> pixels = picture(width, height, static_cast<std::uint32_t>(tjPixelSize[format]));
  const std::unique_ptr<void, decltype(&tjDestroy)> coder(tjInitCompress(), &tjDestroy);
  unsigned char* out = nullptr;
  unsigned long size = 0;
  EXPECT_EQ(tjCompress2(coder.get(), pixels.data(), static_cast<int>(width), 0, static_cast<int>(height), format, &out,
                        &size, format == TJPF_CMYK ? TJSAMP_444 : TJSAMP_420, 90, flags),
            0);
  const std::unique_ptr<unsigned char, decltype(&tjFree)> owned(out, &tjFree);
  return bytes_of(out, size);
}

Bytes webp(std::uint32_t width, std::uint32_t height, bool lossless) {
  const std::vector<std::uint8_t> pixels = picture(width, height, 4);
  std::uint8_t* out = nullptr;
  const auto w = static_cast<int>(width);
  const auto h = static_cast<int>(height);
  const std::size_t size = lossless ? WebPEncodeLosslessRGBA(pixels.data(), w, h, 4 * w, &out)
                                    : WebPEncodeRGBA(pixels.data(), w, h, 4 * w, 90, &out);
  const std::unique_ptr<std::uint8_t, decltype(&WebPFree)> owned(out, &WebPFree);
  return bytes_of(out, size);
}

void expect_picture(const Result<DecodedImage>& image, std::uint32_t width, std::uint32_t height,
                    std::uint32_t channels) {
  ASSERT_TRUE(image.ok()) << image.error().message;
  ASSERT_EQ(image->width, width);
  ASSERT_EQ(image->height, height);
  ASSERT_EQ(image->channels, channels);
  ASSERT_EQ(image->pixels.size(), std::size_t{width} * height * channels);
  const auto at = [&](std::uint32_t x, std::uint32_t y, std::uint32_t c) {
    return static_cast<int>(image->pixels[(std::size_t{y} * width + x) * channels + c]);
  };
  EXPECT_NEAR(at(width / 4, height / 4, 0), 250, 16);
  EXPECT_NEAR(at(width / 4, height / 4, 2), 10, 16);
  EXPECT_NEAR(at(3 * width / 4, height / 4, 0), 10, 16);
  EXPECT_NEAR(at(3 * width / 4, height / 4, 2), 250, 16);
  if (channels == 4) {
    EXPECT_EQ(at(0, 0, 3), 255);
    EXPECT_EQ(at(0, height - 1, 3), 0);
  }
}

// As the specification lays it out: the header, a level or two, what its texels are, the texels.
Bytes ktx2(std::uint32_t width, std::uint32_t height, std::uint32_t channels, std::uint32_t scheme,
           std::uint32_t format = 0, const std::string& orientation = "rd", std::uint8_t model = 1) {
  constexpr std::array<std::uint32_t, 5> kSrgb = {0, 15, 22, 29, 43};
  const std::vector<std::uint8_t> pixels = picture(width, height, channels);
  Bytes level = bytes_of(pixels.data(), pixels.size());
  if (scheme == 2) {
    level.resize(ZSTD_compressBound(pixels.size()));
    level.resize(ZSTD_compress(level.data(), level.size(), pixels.data(), pixels.size(), 3));
  } else if (scheme == 3) {
    uLongf size = compressBound(pixels.size());
    level.resize(size);
    EXPECT_EQ(compress(reinterpret_cast<Bytef*>(level.data()), &size, pixels.data(), pixels.size()), Z_OK);
    level.resize(size);
  }
  Bytes file = bytes_of("\xABKTX 20\xBB\r\n\x1A\n", 12);
  const auto put = [&]<class T>(T value) {
    const Bytes bytes = bytes_of(&value, sizeof value);
    file.insert(file.end(), bytes.begin(), bytes.end());
  };
  const std::string words = std::string("KTXorientation\0", 15) + orientation + '\0';
  for (const std::uint32_t value :
       {model == 166  ? 0
        : format != 0 ? format
                      : kSrgb[channels],
        1U, width, height, 0U, 0U, 1U, 1U, scheme, 104U, 44U, 148U, static_cast<std::uint32_t>(4 + words.size())})
    put(value);
  put(std::uint64_t{0});
  put(std::uint64_t{0});
  put(std::uint64_t{200});
  put(std::uint64_t{level.size()});
  put(std::uint64_t{pixels.size()});
  file.resize(104 + 12);
  put(model);
  file.resize(148);
  put(static_cast<std::uint32_t>(words.size()));
  const Bytes key = bytes_of(words.data(), words.size());
  file.insert(file.end(), key.begin(), key.end());
  file.resize(200);
  file.insert(file.end(), level.begin(), level.end());
  return file;
}

std::string refusal(const Bytes& encoded) {
  const auto image = decode_image(encoded);
  return image.ok() ? "read" : image.error().message;
}

TEST(Images, OfEveryFormatComeAsTheyWere) {
  expect_picture(decode_image(jpeg(64, 48)), 64, 48, 3);
  expect_picture(decode_image(jpeg(33, 17, TJFLAG_PROGRESSIVE)), 33, 17, 3);
  expect_picture(decode_image(png(64, 48, 3)), 64, 48, 3);
  expect_picture(decode_image(png(61, 47, 4)), 61, 47, 4);
  expect_picture(decode_image(png(61, 47, 4, true)), 61, 47, 4);
  expect_picture(decode_image(webp(64, 48, true)), 64, 48, 4);
  expect_picture(decode_image(webp(64, 48, false)), 64, 48, 4);
}

TEST(Images, OfKtx2ArePlainTexelsHoweverTheyArePacked) {
  for (const std::uint32_t scheme : {0U, 2U, 3U}) {
    expect_picture(decode_image(ktx2(64, 48, 3, scheme)), 64, 48, 3);
    expect_picture(decode_image(ktx2(61, 47, 4, scheme)), 61, 47, 4);
  }
  const auto grey = decode_image(ktx2(8, 8, 1, 0));
  ASSERT_TRUE(grey.ok());
  EXPECT_EQ(grey->pixels[0], 250);
  const auto swapped = decode_image(ktx2(64, 48, 4, 2, 50));  // blue first
  ASSERT_TRUE(swapped.ok());
  EXPECT_EQ(swapped->pixels[0], 10);
  EXPECT_EQ(swapped->pixels[2], 250);
  const auto upwards = decode_image(ktx2(64, 47, 4, 0, 0, "ru"));
  ASSERT_TRUE(upwards.ok());
  EXPECT_EQ(upwards->pixels[3], 0);  // the lower half is transparent
  EXPECT_EQ(upwards->pixels.back(), 255);
  EXPECT_NE(refusal(ktx2(8, 8, 3, 1, 0)).find("KTX2: BasisLZ, which is not read; write PNG"), std::string::npos);
  EXPECT_NE(refusal(ktx2(8, 8, 3, 2, 0, "rd", 166)).find("KTX2: UASTC, which is not read"), std::string::npos);
  EXPECT_NE(refusal(ktx2(8, 8, 3, 0, 145)).find("format 145 of Vulkan's"), std::string::npos);
  Bytes cube = ktx2(8, 8, 3, 0);
  cube[36] = std::byte{6};
  EXPECT_NE(refusal(cube).find("cube map"), std::string::npos);
  Bytes other = ktx2(8, 8, 3, 0);
  other[20] = std::byte{9};
  EXPECT_EQ(refusal(other), "KTX2: damaged");
  Bytes wide = ktx2(8, 8, 4, 2);
  wide[21] = wide[25] = std::byte{0xFF};
  EXPECT_NE(refusal(wide).find("without smaller levels"), std::string::npos) << refusal(wide);
}

TEST(Images, OfInksAreColours) {
  const auto image = decode_image(jpeg(64, 48, 0, TJPF_CMYK));  // its black is the picture's alpha
  ASSERT_TRUE(image.ok()) << image.error().message;
  EXPECT_EQ(image->channels, 3U);
  EXPECT_NEAR(image->pixels[0], 250, 16);
  EXPECT_NEAR(image->pixels[image->pixels.size() - 1], 0, 16);
}

TEST(Images, ThatAreLargerThanATextureNeedsAreReduced) {
  for (const Bytes& encoded : {png(8200, 8200, 3), jpeg(8200, 8200), webp(8200, 8200, false)}) {
    const auto image = decode_image(encoded);
    ASSERT_TRUE(image.ok()) << image.error().message;
    EXPECT_LE(std::uint64_t{image->width} * image->height, kDecodedPixels);
    expect_picture(image, image->width, image->height, image->channels);
  }
}

TEST(Images, ThatClaimMoreThanTheirBytesHoldAreRefused) {
  Bytes bomb = jpeg(16, 16);
  for (std::size_t i = 0; i + 9 < bomb.size(); ++i)  // the frame's header has the size
    if (bomb[i] == std::byte{0xFF} && bomb[i + 1] == std::byte{0xC0}) bomb[i + 5] = bomb[i + 7] = std::byte{0x40};
  EXPECT_NE(refusal(bomb).find("16400 × 16400 pixels are more than"), std::string::npos) << refusal(bomb);
  EXPECT_EQ(refusal({}), "no bytes");
  EXPECT_EQ(refusal(bytes_of("GIF89a......", 12)), "none of JPEG, PNG, WebP and KTX2");
  EXPECT_EQ(refusal(bytes_of("\xABKTX 20\xBB\r\n\x1A\n    ", 16)), "KTX2: ends early");
}

TEST(Images, ThatAreDamagedAreErrorsOrPicturesOfTheirSize) {
  std::mt19937 random(5);
  for (const Bytes& whole :
       {jpeg(64, 48), jpeg(64, 48, TJFLAG_PROGRESSIVE), png(64, 48, 4), png(64, 48, 4, true), webp(64, 48, true),
        webp(64, 48, false), ktx2(64, 48, 4, 0), ktx2(64, 48, 4, 2), ktx2(64, 48, 3, 3)}) {
    const Bytes half(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(whole.size() / 2));
    EXPECT_FALSE(decode_image(half).ok())
        << "the first byte is " << static_cast<int>(whole[0]) << ", of " << whole.size();
    for (int i = 0; i < 300; ++i) {
      Bytes damaged = whole;
      for (int flips = 0; flips < 3; ++flips)
        damaged[random() % damaged.size()] ^= static_cast<std::byte>(1U << random() % 8);
      const auto image = decode_image(damaged);
      if (!image.ok()) continue;
      EXPECT_EQ(image->pixels.size(), std::size_t{image->width} * image->height * image->channels);
    }
  }
}

}  // namespace
}  // namespace zc::test
