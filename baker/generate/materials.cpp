// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/generate/materials.h"

#include <vector>

namespace zc::generate {

std::span<const Material> city_materials() {
  // Base colours are linear. Wet asphalt, water and glass are dielectrics so smooth that they mirror; the mirrors that
  // tint are metals.
  static const std::vector<Material> kMaterials = {
      {"asphalt_wet", {0.03F, 0.03F, 0.032F}, 0.04F, 0.0F},
      {"asphalt_puddle", {0.014F, 0.015F, 0.017F}, 0.012F, 0.0F},
      {"asphalt_patch", {0.05F, 0.05F, 0.05F}, 0.1F, 0.0F},
      {"manhole_iron", {0.1F, 0.095F, 0.09F}, 0.3F, 0.0F},
      {"lane_white", {0.6F, 0.6F, 0.57F}, 0.2F, 0.0F},
      {"concrete_sidewalk", {0.34F, 0.33F, 0.31F}, 0.85F, 0.0F},
      {"kerb_stone", {0.46F, 0.45F, 0.43F}, 0.7F, 0.0F},
      {"concrete_wet", {0.15F, 0.15F, 0.15F}, 0.06F, 0.0F},
      {"stone_light", {0.46F, 0.42F, 0.36F}, 0.4F, 0.0F},
      {"stone_polished", {0.19F, 0.175F, 0.155F}, 0.06F, 0.0F},
      {"grass", {0.08F, 0.16F, 0.04F}, 0.95F, 0.0F},
      {"soil", {0.1F, 0.06F, 0.035F}, 0.95F, 0.0F},
      {"brick_red", {0.34F, 0.1F, 0.065F}, 0.85F, 0.0F},
      {"brick_brown", {0.2F, 0.105F, 0.07F}, 0.85F, 0.0F},
      {"ochre", {0.58F, 0.36F, 0.12F}, 0.85F, 0.0F},
      {"sandstone", {0.56F, 0.44F, 0.28F}, 0.85F, 0.0F},
      {"plaster_white", {0.74F, 0.72F, 0.67F}, 0.85F, 0.0F},
      {"plaster_cream", {0.7F, 0.6F, 0.41F}, 0.85F, 0.0F},
      {"concrete_grey", {0.38F, 0.38F, 0.37F}, 0.8F, 0.0F},
      {"concrete_dark", {0.17F, 0.17F, 0.175F}, 0.75F, 0.0F},
      {"pastel_blue", {0.33F, 0.48F, 0.64F}, 0.85F, 0.0F},
      {"pastel_green", {0.4F, 0.56F, 0.38F}, 0.85F, 0.0F},
      {"pastel_pink", {0.72F, 0.42F, 0.4F}, 0.85F, 0.0F},
      {"house_yellow", {0.78F, 0.55F, 0.12F}, 0.85F, 0.0F},
      {"house_coral", {0.72F, 0.19F, 0.1F}, 0.85F, 0.0F},
      {"house_teal", {0.07F, 0.35F, 0.36F}, 0.85F, 0.0F},
      {"house_blue", {0.08F, 0.17F, 0.48F}, 0.85F, 0.0F},
      {"roof_slate", {0.085F, 0.095F, 0.11F}, 0.5F, 0.0F},
      {"roof_tile", {0.4F, 0.115F, 0.06F}, 0.8F, 0.0F},
      {"roof_gravel", {0.3F, 0.29F, 0.27F}, 0.9F, 0.0F},
      {"roof_bitumen", {0.075F, 0.075F, 0.08F}, 0.8F, 0.0F},
      {"copper_green", {0.2F, 0.42F, 0.33F}, 0.5F, 0.0F},
      {"metal_corrugated", {0.42F, 0.46F, 0.5F}, 0.4F, 0.0F},
      {"metal_mirror", {0.64F, 0.66F, 0.68F}, 0.05F, 1.0F},
      {"metal_dark", {0.06F, 0.065F, 0.07F}, 0.35F, 0.0F},
      {"metal_galvanised", {0.56F, 0.57F, 0.58F}, 0.32F, 1.0F},
      {"glass_dark", {0.02F, 0.03F, 0.04F}, 0.03F, 0.0F},
      {"glass_blue", {0.025F, 0.045F, 0.07F}, 0.02F, 0.0F},
      {"glass_mirror", {0.68F, 0.72F, 0.75F}, 0.015F, 1.0F},
      {"glass_bronze", {0.66F, 0.54F, 0.4F}, 0.03F, 1.0F},
      {"window_blind", {0.55F, 0.53F, 0.48F}, 0.5F, 0.0F},
      {"door_wood", {0.2F, 0.095F, 0.045F}, 0.5F, 0.0F},
      {"door_green", {0.04F, 0.14F, 0.08F}, 0.4F, 0.0F},
      {"awning_red", {0.55F, 0.06F, 0.05F}, 0.8F, 0.0F},
      {"awning_blue", {0.06F, 0.14F, 0.36F}, 0.8F, 0.0F},
      {"awning_cream", {0.74F, 0.66F, 0.46F}, 0.8F, 0.0F},
      {"tree_trunk", {0.11F, 0.075F, 0.05F}, 0.95F, 0.0F},
      {"leaf_dark", {0.045F, 0.12F, 0.03F}, 0.9F, 0.0F},
      {"leaf_light", {0.12F, 0.23F, 0.04F}, 0.9F, 0.0F},
      {"leaf_autumn", {0.46F, 0.2F, 0.03F}, 0.9F, 0.0F},
      {"tyre_rubber", {0.02F, 0.02F, 0.021F}, 0.6F, 0.0F},
      {"paint_red", {0.52F, 0.03F, 0.025F}, 0.12F, 0.0F},
      {"paint_blue", {0.03F, 0.09F, 0.36F}, 0.12F, 0.0F},
      {"paint_white", {0.74F, 0.74F, 0.74F}, 0.15F, 0.0F},
      {"paint_black", {0.015F, 0.015F, 0.016F}, 0.06F, 0.0F},
      {"paint_silver", {0.5F, 0.52F, 0.54F}, 0.22F, 1.0F},
      {"paint_yellow", {0.75F, 0.5F, 0.03F}, 0.15F, 0.0F},
      {"paint_green", {0.05F, 0.25F, 0.1F}, 0.2F, 0.0F},
      {"signal_red", {0.85F, 0.05F, 0.03F}, 0.3F, 0.0F},
      {"signal_amber", {0.9F, 0.5F, 0.04F}, 0.3F, 0.0F},
      {"signal_green", {0.05F, 0.75F, 0.3F}, 0.3F, 0.0F},
      {"water", {0.01F, 0.03F, 0.035F}, 0.01F, 0.0F},
      {"lamp_glass", {0.88F, 0.84F, 0.72F}, 0.3F, 0.0F},
      {"monument_stone", {0.5F, 0.42F, 0.36F}, 0.5F, 0.0F},
  };
  return kMaterials;
}

}  // namespace zc::generate
