// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/bake.h"

#include <sys/resource.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <glm/geometric.hpp>
#include <string>
#include <thread>
#include <utility>

#include "baker/appearance/city_appearance.h"
#include "baker/bvh/build_pages.h"
#include "baker/cut/cut.h"
#include "baker/encode/encode_nodes.h"
#include "baker/exterior/exterior.h"
#include "baker/light/city_light.h"
#include "baker/proxy/proxy_tree.h"
#include "baker/repair/snap.h"
#include "baker/write/write_index.h"

namespace zc {
namespace {

std::uint64_t peak_rss_bytes() {
  struct rusage usage {};
  if (::getrusage(RUSAGE_SELF, &usage) != 0) return 0;
  return static_cast<std::uint64_t>(usage.ru_maxrss) * 1024;
}

// By area, of what the import gave.
double reflecting_share(const Scene& scene) {
  double all = 0;
  double smooth = 0;
  for (std::size_t t = 0; t < scene.triangles.size(); ++t) {
    const auto& [a, b, c] = scene.triangles[t];
    const double area =
        glm::length(glm::cross(scene.positions[b] - scene.positions[a], scene.positions[c] - scene.positions[a]));
    all += area;
    if (scene.materials[scene.triangle_material[t]].roughness < kReflectingRoughness) smooth += area;
  }
  return all > 0 ? smooth / all : 0;
}

// The stages in order. What a stage needs of the whole city is a member of its input, so that a part of a city goes
// through the same functions.
Result<BakeReport> bake(Scene&& scene, double import_s, const BakeOptions& options, WorldWriter& writer,
                        BakeContext& context) {
  BakeReport report;
  const std::uint64_t source_triangles = scene.triangles.size();
  report.reflecting_share = reflecting_share(scene);
  BakeCache cache;
  if (options.reuse) cache.read(writer.out() / kBakeCacheName);

  ZC_ASSIGN(const WorldLattice lattice, fit_lattice(scene, options.step_log2));
  const double step_m = lattice.step_m();
  const TextureSource textures(scene, lattice);
  ZC_ASSIGN(SnappedScene snapped, snap_scene({std::move(scene), lattice}, context));

  ZC_ASSIGN(RepairedScene repaired, repair_scene(std::move(snapped), context));
  report.repair = std::move(repaired.report);

  ExteriorScene exterior = {std::move(repaired.scene)};
  if (options.exterior) {
    ZC_ASSIGN(exterior, drop_interior(std::move(exterior.scene), context));
  }
  report.interior_faces = exterior.dropped;

  const CellGrid grid = fit_cells(exterior.scene, options.leaf_triangles);
  const std::uint32_t leaf_shift = leaf_step_shift(options.error_m, step_m);
  ZC_ASSIGN(CutScene cut, cut_zones({std::move(exterior.scene), options.leaf_triangles, leaf_shift, grid}, context));
  const std::vector<Material> materials = std::move(cut.materials);
  report.notes = std::move(cut.notes);

  ZC_ASSIGN(ProxyTree proxies, build_proxies({std::move(cut.tree), step_m, options.error_m, options.leaf_triangles,
                                              options.atlas_size > 0, cache, materials},
                                             context));
  report.notes.insert(report.notes.end(), proxies.notes.begin(), proxies.notes.end());
  report.proxies_reused = proxies.reused;
  report.proxies_built = proxies.built;
  report.simplify_work = proxies.work;

  ZC_ASSIGN(EncodedNodes encoded, encode_nodes({std::move(proxies.nodes), step_m, writer, materials}, context));

  ZC_ASSIGN(
      CityAppearance appearance,
      make_appearances({encoded.meshes, encoded.records, options.atlas_size, step_m, textures, materials}, context));

  if (options.light) {
    ZC_ASSIGN(CityLight light,
              light_city({encoded.records, options.sun, step_m, cache, encoded.meshes, materials}, context));
    for (std::size_t i = 0; i < light.zones.size(); ++i) appearance.zones[i].light = std::move(light.zones[i]);
    report.lights_reused = light.reused;
    report.lights_built = light.built;
  }
  if (options.reuse) ZC_TRY(writer.write(kBakeCacheName, cache.encode()));

  ZC_ASSIGN(Pages pages,
            build_pages({std::move(encoded.records), std::move(encoded.meshes), std::move(appearance.zones),
                         std::move(encoded.disk), options.bvh, writer, static_cast<std::uint32_t>(materials.size())},
                        context));
  for (std::size_t i = 0; i < pages.records.size(); ++i)
    (pages.records[i].is_detail() ? report.detail : report.proxies).add(pages.disk[i]);

  ZC_ASSIGN(report.index, write_index({std::move(pages.records), lattice, materials, std::move(cut.crs),
                                       options.light ? options.sun : std::nullopt, source_triangles, writer},
                                      context));
  report.left_out = count_left_out(report.index, report.proxies, report.detail,
                                   {report.interior_faces, proxies.left_out, proxies.left_out_triangles, options.light,
                                    std::move(appearance.atlas_sizes)});
  report.seconds = BakeSeconds::of(context, import_s);
  report.peak_rss_bytes = peak_rss_bytes();
  ZC_TRY(writer.write_text(kBakeReportName, bake_json(report, options)));
  return report;
}

}  // namespace

Result<BakeReport> bake_world(Scene&& scene, double import_s, const BakeOptions& options,
                              const std::filesystem::path& out) {
  ZC_ASSIGN(WorldWriter writer, WorldWriter::open(out));
  return bake_world(std::move(scene), import_s, options, std::move(writer));
}

Result<BakeReport> bake_world(Scene&& scene, double import_s, const BakeOptions& options, WorldWriter writer) {
  if (options.leaf_triangles < 16)
    return Error{ErrorCode::kArgument,
                 "zones need at least 16 triangles, got " + std::to_string(options.leaf_triangles)};
  if (!(options.error_m > 0 && options.error_m <= 100))
    return Error{ErrorCode::kArgument, "the error bound must be above 0 and at most 100 m"};
  const unsigned threads = options.threads > 0 ? options.threads : std::max(1U, std::thread::hardware_concurrency());
  // As many threads as asked for, also when there are fewer cores.
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
  tbb::task_arena arena(static_cast<int>(threads));
  BakeContext context(threads, options.progress);
  std::optional<Result<BakeReport>> report;
  arena.execute([&] { report.emplace(bake(std::move(scene), import_s, options, writer, context)); });
  if (!report->ok()) return *std::move(report);
  ZC_TRY(writer.commit());
  return *std::move(report);
}

}  // namespace zc
