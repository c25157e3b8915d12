// SPDX-License-Identifier: Apache-2.0
// FLIP: the difference that a person sees when two pictures alternate, 0 to 1 a pixel. Source: Andersson, Nilsson,
// Akenine-Möller, Oskarsson, Åström & Fairchild 2020, "FLIP: A difference evaluator for alternating images"; for
// pictures of low dynamic range. Thread-safe: no state.
#pragma once

#include <vector>

#include "replay/image/drawing.h"

namespace zc {

// What a 0.7 m wide display of 3840 pixels at 0.7 m shows: the authors' default.
inline constexpr double kPixelsPerDegree = 67.0206;

// Per pixel, rows. Both pictures have one size.
std::vector<float> flip_map(const Picture& reference, const Picture& test, double pixels_per_degree = kPixelsPerDegree);
double mean_of_flip(const std::vector<float>& map);

// Magma (Smith & van der Walt 2015) at the root of a difference, dark for none: 0.05, which is seen when pictures
// alternate, has 0.22 of the way to itself.
Rgb flip_color(float difference);
// The map in these colours, scaled down to a width by the mean of each box.
Picture flip_picture(const std::vector<float>& map, std::uint32_t width, std::uint32_t height,
                     std::uint32_t shown_width);

}  // namespace zc
