// SPDX-License-Identifier: Apache-2.0
// What the picture must show, whatever the city: the floor mirrors and nothing else does; the box is red in it, once in
// the host's own picture; the sky is the host's; the city is in front of it. Writes the picture as PPM.
#pragma once

#include <array>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <glm/gtc/packing.hpp>
#include <glm/vec4.hpp>
#include <span>

#include "runtime/reflections.h"

inline bool check_picture(std::span<const std::byte> halves, std::uint32_t width, std::uint32_t height,
                          const zc::FrameReport& report, const char* path) {
  std::ofstream file(path, std::ios::binary);
  file << "P6 " << width << ' ' << height << " 255\n";
  std::uint32_t mirrors = 0, red = 0, sky = 0, wrong = 0;
  for (std::uint32_t i = 0; i < width * height; ++i) {
    std::array<std::uint16_t, 4> half{};
    std::memcpy(half.data(), halves.data() + i * sizeof(half), sizeof(half));
    glm::vec4 p;
    for (int k = 0; k < 4; ++k) p[k] = glm::unpackHalf1x16(half[static_cast<std::size_t>(k)]);
    for (int k = 0; k < 3; ++k) file.put(static_cast<char>(255 * std::sqrt(std::min(p[k], 1.0F))));
    mirrors += p.a == 1 ? 1 : 0;
    wrong += p.a == 1 && i / width < height / 6 ? 1 : 0;  // above the horizon
    red += p.r > 5 * p.b && p.r > 5 * p.g ? 1 : 0;
    sky += p == glm::vec4(0, 0, 4, 1) ? 1 : 0;
  }
  const zc::gpu::Counters& c = report.counters;
  std::printf("%u pixels mirror, %u above the horizon; %u show the box, %u the sky; %u rays hit zones\n", mirrors,
              wrong, red, sky, c.rays_proxy);
  return wrong == 0 && mirrors == c.pixel_count && red >= 500 && c.rays_screen >= 500 && sky >= 500 &&
         c.rays_proxy >= 1000;
}
