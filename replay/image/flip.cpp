// SPDX-License-Identifier: Apache-2.0
#include "replay/image/flip.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>

#include "base/check.h"

namespace zc {
namespace {

using Color = std::array<float, 3>;

struct Plane {
  std::size_t width = 0;
  std::size_t height = 0;
  std::vector<float> values;
};

// A filter along one axis, odd in length, centre in the middle.
using Kernel = std::vector<float>;

// Rows and columns beyond the border repeat the last. Whole rows at a time, so that compilers use vectors.
Plane filtered(const Plane& in, const Kernel& along_x, const Kernel& along_y) {
  const auto w = static_cast<std::ptrdiff_t>(in.width);
  const auto h = static_cast<std::ptrdiff_t>(in.height);
  const auto add = [w](float* to, float factor, const float* from) {
    for (std::ptrdiff_t x = 0; x < w; ++x) to[x] += factor * from[x];
  };
  Plane across{in.width, in.height, std::vector<float>(in.values.size())};
  const auto radius_x = static_cast<std::ptrdiff_t>(along_x.size() / 2);
  std::vector<float> padded(in.width + 2 * static_cast<std::size_t>(radius_x));
  for (std::ptrdiff_t y = 0; y < h; ++y) {
    const float* row = in.values.data() + y * w;
    std::fill_n(padded.begin(), radius_x, row[0]);
    std::copy_n(row, w, padded.begin() + radius_x);
    std::fill_n(padded.begin() + radius_x + w, radius_x, row[w - 1]);
    for (std::size_t k = 0; k < along_x.size(); ++k) add(across.values.data() + y * w, along_x[k], padded.data() + k);
  }
  Plane out{in.width, in.height, std::vector<float>(in.values.size())};
  const auto radius_y = static_cast<std::ptrdiff_t>(along_y.size() / 2);
  for (std::ptrdiff_t y = 0; y < h; ++y)
    for (std::ptrdiff_t k = -radius_y; k <= radius_y; ++k)
      add(out.values.data() + y * w, along_y[static_cast<std::size_t>(k + radius_y)],
          across.values.data() + std::clamp<std::ptrdiff_t>(y + k, 0, h - 1) * w);
  return out;
}

float linear_of(std::uint8_t value) {
  static const std::array<float, 256> table = [] {
    std::array<float, 256> out{};
    for (std::size_t i = 0; i < out.size(); ++i) {
      const double s = static_cast<double>(i) / 255;
      out[i] = static_cast<float>(s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4));
    }
    return out;
  }();
  return table[value];
}

// XYZ over that of the white of sRGB (D65).
Color relative_xyz(const Color& rgb) {
  constexpr std::array<std::array<float, 3>, 3> kRows = {{{0.4123907993F, 0.3575843394F, 0.1804807884F},
                                                          {0.2126390059F, 0.7151686788F, 0.0721923154F},
                                                          {0.0193308187F, 0.1191947798F, 0.9505321522F}}};
  Color out{};
  for (std::size_t r = 0; r < 3; ++r)
    out[r] = (kRows[r][0] * rgb[0] + kRows[r][1] * rgb[1] + kRows[r][2] * rgb[2]) /
             (kRows[r][0] + kRows[r][1] + kRows[r][2]);
  return out;
}

Color rgb_of_relative_xyz(const Color& xyz) {
  constexpr Color kWhite = {0.9504559271F, 1.0F, 1.0890577508F};
  constexpr std::array<std::array<float, 3>, 3> kRows = {{{3.2409699419F, -1.5373831776F, -0.4986107603F},
                                                          {-0.9692436363F, 1.8759675015F, 0.0415550574F},
                                                          {0.0556300797F, -0.2039769589F, 1.0569715142F}}};
  Color out{};
  for (std::size_t r = 0; r < 3; ++r)
    out[r] = kRows[r][0] * xyz[0] * kWhite[0] + kRows[r][1] * xyz[1] * kWhite[1] + kRows[r][2] * xyz[2] * kWhite[2];
  return out;
}

// Linear opponent space that contrast sensitivity is known in.
Color opponent_of(const Color& rgb) {
  const Color n = relative_xyz(rgb);
  return {116 * n[1] - 16, 500 * (n[0] - n[1]), 200 * (n[1] - n[2])};
}
Color rgb_of_opponent(const Color& c) {
  const float y = (c[0] + 16) / 116;
  return rgb_of_relative_xyz({y + c[1] / 500, y, y - c[2] / 200});
}

// CIE L*a*b*, a and b less for dark colours (Hunt).
Color hunt_lab(const Color& rgb) {
  const auto f = [](float t) {
    constexpr float kDelta = 6.0F / 29;
    return t > kDelta * kDelta * kDelta ? std::cbrt(t) : t / (3 * kDelta * kDelta) + 4.0F / 29;
  };
  const Color n = relative_xyz(rgb);
  const float l = 116 * f(n[1]) - 16;
  return {l, 0.01F * l * 500 * (f(n[0]) - f(n[1])), 0.01F * l * 200 * (f(n[1]) - f(n[2]))};
}

float hyab(const Color& a, const Color& b) { return std::abs(a[0] - b[0]) + std::hypot(a[1] - b[1], a[2] - b[2]); }

struct Opponents {
  std::array<Plane, 3> planes;
};

Opponents opponents_of(const Picture& picture) {
  Opponents out;
  const std::size_t count = std::size_t{picture.width} * picture.height;
  for (Plane& plane : out.planes) plane = {picture.width, picture.height, std::vector<float>(count)};
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint8_t* p = picture.rgba.data() + 4 * i;
    const Color c = opponent_of({linear_of(p[0]), linear_of(p[1]), linear_of(p[2])});
    for (std::size_t k = 0; k < 3; ++k) out.planes[k].values[i] = c[k];
  }
  return out;
}

struct Gaussian {
  double weight;
  double width;  // square degrees
};

// Section 4.1.1: what of each channel the eye still sees at this distance. The sum of two Gaussians is no product of
// filters along x and y, each of them is.
Plane seen(const Plane& plane, std::array<Gaussian, 2> parts, double pixels_per_degree) {
  constexpr double kWidest = 0.04;
  const auto radius = static_cast<int>(
      std::ceil(3 * std::sqrt(kWidest / (2 * std::numbers::pi * std::numbers::pi)) * pixels_per_degree));
  Plane out{plane.width, plane.height, std::vector<float>(plane.values.size())};
  double total = 0;
  std::array<Kernel, 2> kernels;
  std::array<double, 2> scale{};
  for (std::size_t i = 0; i < 2; ++i) {
    double sum = 0;
    for (int x = -radius; x <= radius; ++x) {
      const double degrees = x / pixels_per_degree;
      const double g = std::exp(-std::numbers::pi * std::numbers::pi * degrees * degrees / parts[i].width);
      kernels[i].push_back(static_cast<float>(g));
      sum += g;
    }
    scale[i] = parts[i].weight * std::sqrt(std::numbers::pi / parts[i].width);
    total += scale[i] * sum * sum;
  }
  for (std::size_t i = 0; i < 2; ++i) {
    if (parts[i].weight == 0) continue;
    const Plane part = filtered(plane, kernels[i], kernels[i]);
    const auto factor = static_cast<float>(scale[i] / total);
    for (std::size_t p = 0; p < out.values.size(); ++p) out.values[p] += factor * part.values[p];
  }
  return out;
}

// Section 4.2: how strong edges and points are at each pixel.
struct Features {
  std::vector<float> edges;
  std::vector<float> points;
};

Features features_of(const Plane& achromatic, double pixels_per_degree) {
  constexpr double kFeatureDegrees = 0.082;
  const double deviation = 0.5 * kFeatureDegrees * pixels_per_degree;
  const auto radius = static_cast<int>(std::ceil(3 * deviation));
  Kernel smooth;
  Kernel edge;
  Kernel point;
  for (int x = -radius; x <= radius; ++x) {
    const double g = std::exp(-x * x / (2 * deviation * deviation));
    smooth.push_back(static_cast<float>(g));
    edge.push_back(static_cast<float>(-x * g));
    point.push_back(static_cast<float>((x * x / (deviation * deviation) - 1) * g));
  }
  // Positive weights of the whole filter sum to one, negative ones to minus one.
  const double across = std::accumulate(smooth.begin(), smooth.end(), 0.0);
  const auto normalise = [&](Kernel& kernel) {
    double positive = 0;
    double negative = 0;
    for (const float k : kernel) (k > 0 ? positive : negative) += std::abs(k) * across;
    for (float& k : kernel) k = static_cast<float>(k / (k > 0 ? positive : negative));
  };
  normalise(edge);
  normalise(point);
  const auto strength = [&](const Kernel& kernel) {
    const Plane x = filtered(achromatic, kernel, smooth);
    const Plane y = filtered(achromatic, smooth, kernel);
    std::vector<float> out(x.values.size());
    for (std::size_t i = 0; i < out.size(); ++i) out[i] = std::hypot(x.values[i], y.values[i]);
    return out;
  };
  return {strength(edge), strength(point)};
}

}  // namespace

std::vector<float> flip_map(const Picture& reference, const Picture& test, double pixels_per_degree) {
  ZC_CHECK(reference.width == test.width && reference.height == test.height);
  constexpr std::array<std::array<Gaussian, 2>, 3> kSensitivity = {
      {{{{1, 0.0047}, {0, 1e-5}}}, {{{1, 0.0053}, {0, 1e-5}}}, {{{34.1, 0.04}, {13.5, 0.025}}}}};
  constexpr float kColorExponent = 0.7F;
  constexpr float kFeatureExponent = 0.5F;
  constexpr float kKnee = 0.4F;
  constexpr float kBelowKnee = 0.95F;

  std::array<Opponents, 2> pictures = {opponents_of(reference), opponents_of(test)};
  std::array<Features, 2> features;
  std::array<std::array<Plane, 3>, 2> visible;
  for (std::size_t i = 0; i < 2; ++i) {
    for (std::size_t k = 0; k < 3; ++k) visible[i][k] = seen(pictures[i].planes[k], kSensitivity[k], pixels_per_degree);
    Plane achromatic = std::move(pictures[i].planes[0]);
    for (float& v : achromatic.values) v = (v + 16) / 116;
    features[i] = features_of(achromatic, pixels_per_degree);
  }
  const float most = std::pow(hyab(hunt_lab({0, 1, 0}), hunt_lab({0, 0, 1})), kColorExponent);
  std::vector<float> map(visible[0][0].values.size());
  for (std::size_t p = 0; p < map.size(); ++p) {
    std::array<Color, 2> lab;
    for (std::size_t i = 0; i < 2; ++i) {
      Color rgb = rgb_of_opponent({visible[i][0].values[p], visible[i][1].values[p], visible[i][2].values[p]});
      for (float& c : rgb) c = std::clamp(c, 0.0F, 1.0F);
      lab[i] = hunt_lab(rgb);
    }
    const float difference = std::pow(hyab(lab[0], lab[1]), kColorExponent);
    const float knee = kKnee * most;
    const float color = difference < knee ? difference * kBelowKnee / knee
                                          : kBelowKnee + (difference - knee) / (most - knee) * (1 - kBelowKnee);
    const float feature = std::pow(std::max(std::abs(features[0].edges[p] - features[1].edges[p]),
                                            std::abs(features[0].points[p] - features[1].points[p])) /
                                       std::numbers::sqrt2_v<float>,
                                   kFeatureExponent);
    map[p] = std::clamp(std::pow(color, 1 - std::min(feature, 1.0F)), 0.0F, 1.0F);
  }
  return map;
}

double mean_of_flip(const std::vector<float>& map) {
  return map.empty() ? 0 : std::accumulate(map.begin(), map.end(), 0.0) / static_cast<double>(map.size());
}

Rgb flip_color(float difference) {
  constexpr std::array<std::array<float, 3>, 9> kStops = {{{0, 0, 4},
                                                           {28, 16, 68},
                                                           {79, 18, 123},
                                                           {129, 37, 129},
                                                           {181, 54, 122},
                                                           {229, 80, 100},
                                                           {251, 135, 97},
                                                           {254, 194, 135},
                                                           {252, 253, 191}}};
  const float at = std::sqrt(std::clamp(difference, 0.0F, 1.0F)) * (kStops.size() - 1);
  const auto low = std::min(static_cast<std::size_t>(at), kStops.size() - 2);
  const float part = at - static_cast<float>(low);
  Rgb out{};
  for (std::size_t c = 0; c < out.size(); ++c)
    out[c] = static_cast<std::uint8_t>(kStops[low][c] + (kStops[low + 1][c] - kStops[low][c]) * part + 0.5F);
  return out;
}

Picture flip_picture(const std::vector<float>& map, std::uint32_t width, std::uint32_t height,
                     std::uint32_t shown_width) {
  shown_width = std::min(shown_width, width);
  const std::uint32_t shown_height = std::max(1U, height * shown_width / width);
  Picture out{shown_width, shown_height, std::vector<std::uint8_t>(std::size_t{4} * shown_width * shown_height, 255)};
  for (std::uint32_t y = 0; y < shown_height; ++y) {
    const std::uint32_t y0 = y * height / shown_height;
    const std::uint32_t y1 = std::max(y0 + 1, (y + 1) * height / shown_height);
    for (std::uint32_t x = 0; x < shown_width; ++x) {
      const std::uint32_t x0 = x * width / shown_width;
      const std::uint32_t x1 = std::max(x0 + 1, (x + 1) * width / shown_width);
      float sum = 0;
      for (std::uint32_t sy = y0; sy < y1; ++sy)
        for (std::uint32_t sx = x0; sx < x1; ++sx) sum += map[std::size_t{sy} * width + sx];
      const Rgb color = flip_color(sum / static_cast<float>((y1 - y0) * (x1 - x0)));
      std::ranges::copy(color, out.rgba.begin() + (std::ptrdiff_t{y} * shown_width + x) * 4);
    }
  }
  return out;
}

}  // namespace zc
