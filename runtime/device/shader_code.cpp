// SPDX-License-Identifier: Apache-2.0
#include "runtime/device/shader_code.h"

#include "spirv/bench/resolve_plain.comp.h"
#include "spirv/bench/spin.comp.h"
#include "spirv/bench/trace_bvh2.comp.h"
#include "spirv/bench/trace_plain_children.comp.h"
#include "spirv/bench/trace_plain_packets.comp.h"
#include "spirv/bench/trace_plain_rays.comp.h"
#include "spirv/bench/trace_ray_query.comp.h"
#include "spirv/bench/trace_thesis.comp.h"
#include "spirv/packets/trace_packets.comp.h"
#include "spirv/passes/classify_pixels.comp.h"
#include "spirv/passes/composite_frame.comp.h"
#include "spirv/passes/draw_lines.frag.h"
#include "spirv/passes/draw_lines.vert.h"
#include "spirv/passes/draw_zone.frag.h"
#include "spirv/passes/draw_zone.vert.h"
#include "spirv/passes/light_surfaces.comp.h"
#include "spirv/passes/march_screen.comp.h"
#include "spirv/passes/reduce_depth.comp.h"
#include "spirv/passes/resolve_hits.comp.h"
#include "spirv/passes/shade_hits.comp.h"
#include "spirv/passes/show_debug.comp.h"
#include "spirv/passes/size_dispatch.comp.h"
#include "spirv/passes/trace_rays.comp.h"

namespace zc::shader {

std::span<const std::uint32_t> draw_zone_vert() { return ::draw_zone_vert; }
std::span<const std::uint32_t> draw_zone_frag() { return ::draw_zone_frag; }
std::span<const std::uint32_t> draw_lines_vert() { return ::draw_lines_vert; }
std::span<const std::uint32_t> draw_lines_frag() { return ::draw_lines_frag; }
std::span<const std::uint32_t> light_surfaces() { return ::light_surfaces_comp; }
std::span<const std::uint32_t> reduce_depth() { return ::reduce_depth_comp; }
std::span<const std::uint32_t> classify_pixels() { return ::classify_pixels_comp; }
std::span<const std::uint32_t> size_dispatch() { return ::size_dispatch_comp; }
std::span<const std::uint32_t> march_screen() { return ::march_screen_comp; }
std::span<const std::uint32_t> trace_packets() { return ::trace_packets_comp; }
std::span<const std::uint32_t> trace_rays() { return ::trace_rays_comp; }
std::span<const std::uint32_t> resolve_hits() { return ::resolve_hits_comp; }
std::span<const std::uint32_t> shade_hits() { return ::shade_hits_comp; }
std::span<const std::uint32_t> composite_frame() { return ::composite_frame_comp; }
std::span<const std::uint32_t> show_debug() { return ::show_debug_comp; }
std::span<const std::uint32_t> bench_spin() { return ::bench_spin_comp; }
std::span<const std::uint32_t> bench_trace_bvh2() { return ::bench_trace_bvh2_comp; }
std::span<const std::uint32_t> bench_trace_ray_query() { return ::bench_trace_ray_query_comp; }
std::span<const std::uint32_t> bench_trace_thesis() { return ::bench_trace_thesis_comp; }
std::span<const std::uint32_t> bench_trace_plain_rays() { return ::bench_trace_plain_rays_comp; }
std::span<const std::uint32_t> bench_trace_plain_children() { return ::bench_trace_plain_children_comp; }
std::span<const std::uint32_t> bench_trace_plain_packets() { return ::bench_trace_plain_packets_comp; }
std::span<const std::uint32_t> bench_resolve_plain() { return ::bench_resolve_plain_comp; }

}  // namespace zc::shader
