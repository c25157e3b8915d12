// SPDX-License-Identifier: Apache-2.0
// Structs in shaders/shared are compiled by GLSL and by C++: their offsets and sizes must be the same bytes.
#include <gtest/gtest.h>
#include <spirv_cross/spirv_cross_c.h>

#include <cstddef>
#include <map>
#include <string>

#include "shaders/shared/frame.h"
#include "shaders/shared/scene.h"
#include "spirv/host.h"
#include "spirv/passes.h"

namespace {

using Offsets = std::map<std::string, std::size_t>;
struct Layout {
  std::size_t size;
  Offsets offsets;
};

#define AT(type, member) \
  { #member, offsetof(zc::gpu::type, member) }

const std::map<std::string, Layout>& host_layouts() {
  static const std::map<std::string, Layout> layouts = {
      {"ZoneEntry",
       {sizeof(zc::gpu::ZoneEntry), {AT(ZoneEntry, page_word), AT(ZoneEntry, node), AT(ZoneEntry, flags)}}},
      {"MaterialEntry",
       {sizeof(zc::gpu::MaterialEntry),
        {AT(MaterialEntry, base_r), AT(MaterialEntry, base_g), AT(MaterialEntry, base_b), AT(MaterialEntry, roughness),
         AT(MaterialEntry, metallic), AT(MaterialEntry, flags), AT(MaterialEntry, reserved0),
         AT(MaterialEntry, reserved1)}}},
      {"RayTask",
       {sizeof(zc::gpu::RayTask),
        {AT(RayTask, origin_x), AT(RayTask, origin_y), AT(RayTask, origin_z), AT(RayTask, t_min), AT(RayTask, dir_x),
         AT(RayTask, dir_y), AT(RayTask, dir_z), AT(RayTask, origin_normal)}}},
      {"HitRecord",
       {sizeof(zc::gpu::HitRecord), {AT(HitRecord, t), AT(HitRecord, triangle_word), AT(HitRecord, pixel)}}},
      {"ResolvedHit",
       {sizeof(zc::gpu::ResolvedHit), {AT(ResolvedHit, t), AT(ResolvedHit, page_word), AT(ResolvedHit, triangle)}}},
      {"FallbackRays",
       {sizeof(zc::gpu::FallbackRays),
        {AT(FallbackRays, first_ray), AT(FallbackRays, mask_low), AT(FallbackRays, mask_high)}}},
      {"Counters",
       {sizeof(zc::gpu::Counters),
        {AT(Counters, ssr_groups_x),      AT(Counters, ssr_groups_y),      AT(Counters, ssr_groups_z),
         AT(Counters, trace_groups_x),    AT(Counters, trace_groups_y),    AT(Counters, trace_groups_z),
         AT(Counters, pixel_count),       AT(Counters, ray_count),         AT(Counters, rays_screen),
         AT(Counters, rays_proxy),        AT(Counters, rays_proxy_coarse), AT(Counters, rays_sky),
         AT(Counters, rays_lost),         AT(Counters, fallback_count),    AT(Counters, packet_groups_x),
         AT(Counters, packet_groups_y),   AT(Counters, packet_groups_z),   AT(Counters, fallback_groups_x),
         AT(Counters, fallback_groups_y), AT(Counters, fallback_groups_z), AT(Counters, out_of_page)}}},
      {"FrameData", {sizeof(zc::gpu::FrameData), {AT(FrameData, view_projection), AT(FrameData, eye),
                                                  AT(FrameData, right),           AT(FrameData, up),
                                                  AT(FrameData, forward),         AT(FrameData, sun_direction),
                                                  AT(FrameData, sun_radiance),    AT(FrameData, camera_lattice),
                                                  AT(FrameData, near_m),          AT(FrameData, tan_half_fov_x),
                                                  AT(FrameData, tan_half_fov_y),  AT(FrameData, ray_length_m),
                                                  AT(FrameData, step_m),          AT(FrameData, roughness_cut),
                                                  AT(FrameData, sun_is_baked),    AT(FrameData, screen_step_limit),
                                                  AT(FrameData, width),           AT(FrameData, height),
                                                  AT(FrameData, hiz_level_count), AT(FrameData, reserved),
                                                  AT(FrameData, root_word),       AT(FrameData, zone_count),
                                                  AT(FrameData, end_word),        AT(FrameData, reserved1),
                                                  AT(FrameData, hiz_levels)}}}};
  return layouts;
}

// Compares every known struct in the shader's uniform and storage blocks; returns their names.
std::map<std::string, int> compare_blocks(std::span<const std::uint32_t> spirv) {
  std::map<std::string, int> seen;
  spvc_context context = nullptr;
  EXPECT_EQ(spvc_context_create(&context), SPVC_SUCCESS);
  spvc_parsed_ir ir = nullptr;
  EXPECT_EQ(spvc_context_parse_spirv(context, spirv.data(), spirv.size(), &ir), SPVC_SUCCESS);
  spvc_compiler compiler = nullptr;
  EXPECT_EQ(spvc_context_create_compiler(context, SPVC_BACKEND_NONE, ir, SPVC_CAPTURE_MODE_TAKE_OWNERSHIP, &compiler),
            SPVC_SUCCESS);
  spvc_resources resources = nullptr;
  EXPECT_EQ(spvc_compiler_create_shader_resources(compiler, &resources), SPVC_SUCCESS);
  for (const spvc_resource_type kind : {SPVC_RESOURCE_TYPE_STORAGE_BUFFER, SPVC_RESOURCE_TYPE_UNIFORM_BUFFER}) {
    const spvc_reflected_resource* list = nullptr;
    std::size_t count = 0;
    EXPECT_EQ(spvc_resources_get_resource_list_for_type(resources, kind, &list, &count), SPVC_SUCCESS);
    for (std::size_t r = 0; r < count; ++r) {
      const spvc_type block = spvc_compiler_get_type_handle(compiler, list[r].base_type_id);
      const spvc_type member = spvc_compiler_get_type_handle(compiler, spvc_type_get_member_type(block, 0));
      const SpvId id = spvc_type_get_base_type_id(member);
      const spvc_type type = spvc_compiler_get_type_handle(compiler, id);
      if (spvc_type_get_basetype(type) != SPVC_BASETYPE_STRUCT) continue;
      const std::string name = spvc_compiler_get_name(compiler, id);
      const auto host = host_layouts().find(name);
      if (host == host_layouts().end()) {
        ADD_FAILURE() << "struct " << name << " is in a shader block but not compared here";
        continue;
      }
      ++seen[name];
      EXPECT_EQ(spvc_type_get_num_member_types(type), host->second.offsets.size()) << name;
      for (unsigned m = 0; m < spvc_type_get_num_member_types(type); ++m) {
        unsigned offset = 0;
        EXPECT_EQ(spvc_compiler_type_struct_member_offset(compiler, type, m, &offset), SPVC_SUCCESS);
        const std::string field = spvc_compiler_get_member_name(compiler, id, m);
        EXPECT_TRUE(host->second.offsets.contains(field)) << name << "." << field;
        if (host->second.offsets.contains(field)) {
          EXPECT_EQ(offset, host->second.offsets.at(field)) << name << "." << field;
        }
      }
      if (spvc_type_get_num_array_dimensions(member) > 0) {
        unsigned stride = 0;
        EXPECT_EQ(spvc_compiler_type_struct_member_array_stride(compiler, block, 0, &stride), SPVC_SUCCESS);
        EXPECT_EQ(stride, host->second.size) << name;
      } else {
        std::size_t size = 0;
        EXPECT_EQ(spvc_compiler_get_declared_struct_size(compiler, type, &size), SPVC_SUCCESS);
        EXPECT_EQ(size, host->second.size) << name;
      }
    }
  }
  spvc_context_destroy(context);
  return seen;
}

TEST(SharedLayout, EveryStructHasTheOffsetsThatTheShadersUse) {
  std::map<std::string, int> seen;
  for (const auto& shader :
       {zc::shader::draw_zone_vert(), zc::shader::draw_lines_vert(), zc::shader::light_surfaces(),
        zc::shader::reduce_depth(), zc::shader::classify_pixels(), zc::shader::size_dispatch(),
        zc::shader::march_screen(), zc::shader::trace_packets(), zc::shader::trace_rays(), zc::shader::resolve_hits(),
        zc::shader::shade_hits(), zc::shader::composite_frame(), zc::shader::show_debug()}) {
    for (const auto& [name, count] : compare_blocks(shader)) seen[name] += count;
  }
  for (const auto& [name, layout] : host_layouts()) EXPECT_GT(seen[name], 0) << name << " is in no shader";
}

}  // namespace
