// SPDX-License-Identifier: Apache-2.0
// FLIP: the difference that a person sees when two pictures alternate, 0 to 1 a pixel. Source: Andersson, Nilsson,
// Akenine-Möller, Oskarsson, Åström & Fairchild 2020, "FLIP: A difference evaluator for alternating images"; for
// pictures of low dynamic range. Thread-safe: no state.
#pragma once

#include <vector>

#include "replay/png_file.h"

namespace zc {

// What a 0.7 m wide display of 3840 pixels at 0.7 m shows: the authors' default.
inline constexpr double kPixelsPerDegree = 67.0206;

// Per pixel, rows. Both pictures have one size.
std::vector<float> flip_map(const Picture& reference, const Picture& test, double pixels_per_degree = kPixelsPerDegree);
double mean_of_flip(const std::vector<float>& map);
// The map in the colours of magma, dark for no difference.
Picture flip_picture(const std::vector<float>& map, std::uint32_t width, std::uint32_t height);

}  // namespace zc
