// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/generate/city.h"

#include <cmath>
#include <span>
#include <string>
#include <system_error>
#include <vector>

#include "baker/generate/blocks.h"
#include "baker/generate/drive.h"
#include "baker/generate/furniture.h"
#include "baker/generate/glb_writer.h"
#include "baker/generate/landmarks.h"
#include "baker/generate/layout.h"
#include "baker/generate/streets.h"
#include "base/file.h"

namespace zc {
namespace {

using namespace generate;

void add_ground(GlbWriter& glb, const Layout& layout) {
  add_skirt(glb, layout);
  for (int i = 0; i <= layout.n; ++i) {
    for (int j = 0; j <= layout.n; ++j) add_crossing(glb, layout, i, j);
  }
  for (int line = 0; line <= layout.n; ++line) {
    for (int step = 0; step < layout.n; ++step) {
      add_road(glb, layout, make_segment(layout, true, line, step));
      add_road(glb, layout, make_segment(layout, false, line, step));
    }
  }
  for (int i = 0; i < layout.n; ++i) {
    for (int j = 0; j < layout.n; ++j) add_sidewalk(glb, layout, i, j);
  }
}

void add_blocks(GlbWriter& glb, const Layout& layout, std::span<const Shot> shots) {
  for (int i = 0; i < layout.n; ++i) {
    for (int j = 0; j < layout.n; ++j) {
      switch (layout.use(i, j)) {
        case BlockUse::kTown:
          add_town_block(glb, layout, i, j);
          break;
        case BlockUse::kPark:
          add_park_block(glb, layout, i, j);
          break;
        case BlockUse::kPlaza:
          add_plaza(glb, layout, shots);
          break;
        case BlockUse::kHouses:
          add_coloured_houses(glb, layout);
          break;
        case BlockUse::kWarehouse:
          add_warehouse(glb, layout);
          break;
        case BlockUse::kTireShop:
          add_tire_shop(glb, layout, shots);
          break;
        case BlockUse::kMirror:
          add_mirror_building(glb, layout);
          break;
      }
    }
  }
}

void add_furniture(GlbWriter& glb, const Layout& layout, std::span<const Shot> shots) {
  for (int line = 0; line <= layout.n; ++line) {
    for (int step = 0; step < layout.n; ++step) {
      add_street_furniture(glb, layout, make_segment(layout, true, line, step), shots);
      add_street_furniture(glb, layout, make_segment(layout, false, line, step), shots);
    }
    for (int j = 0; j <= layout.n; ++j) add_traffic_lights(glb, layout, line, j, shots);
  }
}

// A loose belt of trees on the skirt, so that the last street does not end in bare ground.
void add_belt(GlbWriter& glb, const Layout& layout) {
  Rng rng(layout.seed, 0x62656C74, 0, 0);
  const double h = layout.half_size();
  const int per_side = static_cast<int>(h / 4);
  for (int side = 0; side < 4; ++side) {
    for (int k = 0; k < per_side; ++k) {
      const double along = rng.range(-h - 60, h + 60);
      const double away = h + rng.range(9, kSkirt - 8);
      const Vec2 at = side % 2 == 0 ? Vec2{along, side == 0 ? away : -away} : Vec2{side == 1 ? away : -away, along};
      MeshBuilder mesh("belt_tree_" + std::to_string(side) + "_" + std::to_string(k));
      add_tree(mesh, rng, {at, 0}, rng.range(7, 13), false);
      glb.add(mesh);
    }
  }
}

Status write_text(const std::filesystem::path& path, const std::string& text) {
  return write_file(path, std::as_bytes(std::span(text)));
}

}  // namespace

Result<GenerateReport> generate_city(const GenerateOptions& options, const std::filesystem::path& out_dir) {
  if (!(options.size_km >= 0.1 && options.size_km <= 20)) {
    return Error{ErrorCode::kArgument, "the city's size must lie between 0.1 and 20 km"};
  }
  std::error_code failed;
  std::filesystem::create_directories(out_dir, failed);
  if (failed) return Error{ErrorCode::kIo, "cannot make the folder: " + failed.message(), out_dir.string()};

  const Layout layout = make_layout(options.seed, options.size_km * 1000);
  const std::vector<Shot> shots = make_shots(layout);
  GlbWriter glb;
  add_ground(glb, layout);
  add_blocks(glb, layout, shots);
  add_bridge(glb, layout);
  add_furniture(glb, layout, shots);
  add_belt(glb, layout);
  const GenerateReport report = {glb.triangles(), glb.objects()};
  ZC_ASSIGN(const std::vector<std::byte> bytes, glb.finish());
  ZC_TRY(write_file(out_dir / "city.glb", bytes));
  ZC_TRY(write_text(out_dir / "drive.csv", drive_csv(make_drive(layout))));
  ZC_TRY(write_text(out_dir / "shots.json", shots_json(shots)));
  return report;
}

}  // namespace zc
