// SPDX-License-Identifier: Apache-2.0
// The SPIR-V that glslang made at build time.
#pragma once

#include <cstdint>
#include <span>

namespace zc::shader {

std::span<const std::uint32_t> draw_zone_vert();
std::span<const std::uint32_t> draw_zone_frag();
std::span<const std::uint32_t> draw_lines_vert();
std::span<const std::uint32_t> draw_lines_frag();
std::span<const std::uint32_t> light_surfaces();
std::span<const std::uint32_t> reduce_depth();
std::span<const std::uint32_t> classify_pixels();
std::span<const std::uint32_t> size_dispatch();
std::span<const std::uint32_t> march_screen();
std::span<const std::uint32_t> trace_packets();
std::span<const std::uint32_t> trace_rays();
std::span<const std::uint32_t> resolve_hits();
std::span<const std::uint32_t> shade_hits();
std::span<const std::uint32_t> composite_frame();
std::span<const std::uint32_t> show_debug();

// Kernels of `zonecast bench`.
std::span<const std::uint32_t> bench_spin();
std::span<const std::uint32_t> bench_trace_bvh2();
std::span<const std::uint32_t> bench_trace_ray_query();  // needs Device::has_ray_query
std::span<const std::uint32_t> bench_trace_thesis();
std::span<const std::uint32_t> bench_trace_plain_rays();
std::span<const std::uint32_t> bench_trace_plain_children();
std::span<const std::uint32_t> bench_trace_plain_packets();
std::span<const std::uint32_t> bench_resolve_plain();

}  // namespace zc::shader
