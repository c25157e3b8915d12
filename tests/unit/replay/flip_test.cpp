// SPDX-License-Identifier: Apache-2.0
// Expected values: the authors' own evaluator, flip-evaluator 1.x on PyPI (BSD-3-Clause), on the same pictures.
#include "replay/image/flip.h"

#include <gtest/gtest.h>

#include <array>
#include <functional>

namespace zc {
namespace {

constexpr std::uint32_t kWidth = 96;
constexpr std::uint32_t kHeight = 64;

using Pixel = std::array<std::uint32_t, 3>;
using Pattern = std::function<Pixel(std::uint32_t x, std::uint32_t y)>;

Pixel base(std::uint32_t x, std::uint32_t y) { return {x * 5 % 256, (y * 7 + x) % 256, x * y % 256}; }

Picture picture_of(const Pattern& pattern) {
  Picture picture{kWidth, kHeight, {}};
  for (std::uint32_t y = 0; y < kHeight; ++y)
    for (std::uint32_t x = 0; x < kWidth; ++x) {
      for (const std::uint32_t c : pattern(x, y)) picture.rgba.push_back(static_cast<std::uint8_t>(c));
      picture.rgba.push_back(255);
    }
  return picture;
}

struct Case {
  const char* name;
  Pattern pattern;
  double mean;
  float at_10_10;
  float at_40_30;
};

TEST(Flip, IsWhatItsAuthorsEvaluatorSays) {
  const std::array<Case, 4> cases = {{
      {"shifted", [](auto x, auto y) { return base(x + 1, y); }, 0.144395, 0.146096F, 0.182217F},
      {"tinted",
       [](auto x, auto y) {
         Pixel p = base(x, y);
         p[0] = std::min(p[0] + 20, 255U);
         return p;
       },
       0.188336, 0.145436F, 0.251048F},
      {"window",
       [](auto x, auto y) {
         return x >= 30 && x < 50 && y >= 20 && y < 40 ? Pixel{255, 0, 0} : base(x, y);
       },
       0.074011, 0, 0.984666F},
      {"black",
       [](auto, auto) {
         return Pixel{0, 0, 0};
       },
       0.948346, 0.809176F, 0.987072F},
  }};
  const Picture reference = picture_of(base);
  for (const Case& c : cases) {
    const std::vector<float> map = flip_map(reference, picture_of(c.pattern));
    EXPECT_NEAR(mean_of_flip(map), c.mean, 2e-4) << c.name;
    EXPECT_NEAR(map[10 * kWidth + 10], c.at_10_10, 5e-4) << c.name;
    EXPECT_NEAR(map[30 * kWidth + 40], c.at_40_30, 5e-4) << c.name;
  }
}

TEST(Flip, EqualPicturesDoNotDiffer) {
  const Picture picture = picture_of(base);
  for (const float v : flip_map(picture, picture)) ASSERT_EQ(v, 0);
}

}  // namespace
}  // namespace zc
