// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/bake.h"

#include <sys/resource.h>
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <xxhash.h>
#include <atomic>
#include <chrono>
#include <cmath>
#include <limits>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <thread>

#include "baker/appearance/zone_appearance.h"
#include "baker/bvh/build_page.h"
#include "baker/cut/cut.h"
#include "baker/exterior/exterior.h"
#include "baker/light/city_light.h"
#include "baker/proxy/proxy_tree.h"
#include "baker/repair/snap.h"
#include "baker/write/encode.h"
#include "baker/write/tileset.h"
#include "streamer/world_format/bvh_page.h"

namespace zc {
namespace {

// Of the coarsest levels, in texels.
constexpr std::uint32_t kSmallestAtlas = 32;

class Stopwatch {
 public:
  double lap() {
    const auto now = std::chrono::steady_clock::now();
    const double seconds = std::chrono::duration<double>(now - last_).count();
    last_ = now;
    return seconds;
  }

 private:
  std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
};

// Serialises the caller's progress function.
class Progress {
 public:
  explicit Progress(const BakeOptions& options) : report_(options.progress) {}

  void begin(std::string_view stage, double from, double to, std::size_t steps) {
    const std::lock_guard lock(mutex_);
    stage_ = stage;
    from_ = from;
    to_ = to;
    steps_ = steps;
    done_ = 0;
    if (report_) report_(from_, stage_);
  }
  void step() {
    const std::lock_guard lock(mutex_);
    ++done_;
    if (report_ && steps_ > 0)
      report_(from_ + (to_ - from_) * std::min(1.0, static_cast<double>(done_) / static_cast<double>(steps_)), stage_);
  }

 private:
  std::function<void(double, std::string_view)> report_;
  std::mutex mutex_;
  std::string_view stage_;
  double from_ = 0;
  double to_ = 0;
  std::size_t steps_ = 0;
  std::size_t done_ = 0;
};

// Runs `work(i)` for all i in parallel; of several errors the one with the least i is returned.
template <class Work>
Status for_all(std::size_t count, Work work) {
  std::vector<std::optional<Error>> errors(count);
  tbb::parallel_for(std::size_t{0}, count, [&](std::size_t i) {
    if (Status status = work(i); !status.ok()) errors[i] = std::move(status).error();
  });
  for (auto& error : errors)
    if (error) return *std::move(error);
  return {};
}

Status encode_node(const ProxyNode& source, std::span<const Material> materials, double step_m,
                   const WorldWriter& writer, NodeRecord& node, ZoneMesh& decoded, DiskParts& disk) {
  node.parent = source.parent;
  node.first_child = source.child_count > 0 ? source.first_child : 0;
  node.child_count = source.child_count;
  node.flags = source.is_detail ? kNodeDetail : 0;
  node.depth = source.depth;
  node.cell_x = source.cell_x;
  node.cell_y = source.cell_y;
  node.step_shift = source.proxy.step_shift;
  node.error_max_m = static_cast<float>(source.proxy.error.max_m);
  // Still a bound when rounded.
  if (static_cast<double>(node.error_max_m) < source.proxy.error.max_m)
    node.error_max_m = std::nextafter(node.error_max_m, std::numeric_limits<float>::infinity());
  node.appearance_error_m = static_cast<float>(source.proxy.error.appearance_m);
  node.error_mean_m = static_cast<float>(source.proxy.error.mean_m);
  node.normal_deviation_deg = static_cast<float>(source.proxy.error.normal_deviation_deg);
  node.color_error = static_cast<float>(source.proxy.error.color_error);
  ZC_ASSIGN(const EncodedZone zone, encode_zone_glb(source.proxy.mesh, node.step_shift, materials, step_m));
  node.origin = zone.origin;
  node.bounds_min = zone.bounds_min;
  node.bounds_max = zone.bounds_max;
  node.triangle_count = zone.triangle_count;
  node.vertex_count = zone.vertex_count;
  node.primitive_count = zone.primitive_count;
  node.scratch_bytes = decode_scratch_bytes(zone.glb, node);  // build_node_bvh knows the rest
  node.glb_bytes = zone.glb.size();
  disk.triangles = zone.triangle_count;
  disk.mesh = zone.draco_bytes;
  disk.json = zone.glb.size() - zone.draco_bytes;
  node.glb_xxh3 = XXH3_64bits(zone.glb.data(), zone.glb.size());
  const std::string name = node_file(node, "glb");
  // Read as the streamer reads it: the BVH belongs to the decoded mesh.
  ZC_ASSIGN(decoded, decode_zone_glb(zone.glb, node, name));
  decoded.materials = zone.materials;
  return writer.write(name, zone.glb);
}

Status build_node_bvh(const ZoneMesh& mesh, ZoneAppearance appearance, const BvhBuildOptions& options,
                      std::uint32_t material_count, const WorldWriter& writer, NodeRecord& node, DiskParts& disk) {
  const std::string name = node_file(node, "zbvh");
  ZC_ASSIGN(const BuiltPage page, build_page(mesh, std::move(appearance), options, material_count, node, name));
  const auto [bytes, parts] = encode_bvh_file(page.bvh, mesh, node);
  disk.bvh = parts;
  node.bvh_bytes = bytes.size();
  node.scratch_bytes = std::max(node.scratch_bytes, page_scratch_bytes(node, mesh.vertices.size()));
  node.bvh_xxh3 = XXH3_64bits(bytes.data(), bytes.size());
  // Read as the streamer reads it.
  ZoneMesh read = {mesh.vertices, mesh.triangles, {}};
  ZC_ASSIGN(const BvhFile decoded, decode_bvh_file(bytes, read, node, name));
  ZC_ASSIGN(const std::vector<std::uint32_t> words, assemble_page(read, decoded, node, material_count, name));
  if (words != page.words) return Error{ErrorCode::kFormat, "is not the page that it was made from", name};
  return writer.write(name, bytes);
}

// How many levels of proxies lie below each node.
std::vector<std::uint32_t> heights(std::span<const NodeRecord> nodes) {
  std::vector<std::uint32_t> height(nodes.size());
  for (std::size_t i = nodes.size(); i-- > 1;)  // children lie behind their parents
    if (!nodes[i].is_detail()) {
      std::uint32_t& above = height[static_cast<std::size_t>(nodes[i].parent)];
      above = std::max(above, height[i] + 1);
    }
  return height;
}

std::vector<MaterialRecord> material_records(std::span<const Material> materials) {
  std::vector<MaterialRecord> out;
  for (const Material& m : materials) {
    MaterialRecord record;
    record.base_color = {m.base_color.r, m.base_color.g, m.base_color.b};
    record.roughness = m.roughness;
    record.metallic = m.metallic;
    out.push_back(record);
  }
  return out;
}

std::string bake_json(const BakeReport& report) {
  nlohmann::ordered_json json;
  const BakeSeconds& s = report.seconds;
  json["bake_s"] = {
      {"total", s.total},       {"import", s.import_s}, {"repair", s.repair}, {"exterior", s.exterior}, {"cut", s.cut},
      {"simplify", s.simplify}, {"light", s.light},     {"encode", s.encode}, {"atlas", s.atlas},       {"bvh", s.bvh}};
  json["peak_rss_bytes"] = report.peak_rss_bytes;
  json["source_triangles"] = report.index.header.source_triangles;
  json["nodes"] = report.index.nodes.size();
  json["proxies"] = {
      {"reused", report.proxies_reused}, {"built", report.proxies_built}, {"work", report.simplify_work}};
  json["lights"] = {{"reused", report.lights_reused}, {"built", report.lights_built}};
  json["disk_bytes"] = {{"proxies", report.proxies.to_json()}, {"detail", report.detail.to_json()}};
  const auto counts = [](std::span<const ImportCount> notes) {
    auto list = nlohmann::ordered_json::array();
    for (const ImportCount& note : notes) {
      list.push_back({{"what", note.what}, {"count", note.count}});
      if (!note.names.empty()) list.back()["names"] = note.names;
    }
    return list;
  };
  json["repair"] = {{"counts", counts(report.repair.counts)},
                    {"open_edges", report.repair.open_edges},
                    {"border_error_m", report.repair.border_error_m}};
  json["left_out"] = nlohmann::ordered_json::array();
  for (const LeftOut& left : report.left_out) {
    json["left_out"].push_back({{"what", left.what}, {"count", left.count}, {"page_bytes", left.page_bytes}});
    if (left.disk_bytes > 0) json["left_out"].back()["disk_bytes"] = left.disk_bytes;
  }
  json["notes"] = counts(report.notes);
  return json.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

std::uint64_t peak_rss_bytes() {
  struct rusage usage {};
  if (::getrusage(RUSAGE_SELF, &usage) != 0) return 0;
  return static_cast<std::uint64_t>(usage.ru_maxrss) * 1024;
}

Result<BakeReport> bake(Scene&& scene, double import_s, const BakeOptions& options, WorldWriter& writer) {
  Stopwatch all;
  Stopwatch watch;
  Progress progress(options);
  BakeReport report;
  report.seconds.import_s = import_s;
  report.index.header.source_triangles = scene.triangles.size();

  TextureSource textures(scene);
  progress.begin("snap", 0, 0.02, 0);
  ZC_ASSIGN(SnappedScene snapped, snap_scene(std::move(scene), options.step_log2));
  ZC_ASSIGN(report.repair, repair_scene(snapped));
  report.seconds.repair = watch.lap();
  const auto threads = static_cast<unsigned>(tbb::this_task_arena::max_concurrency());
  if (options.exterior) {
    progress.begin("exterior", 0.02, 0.02, 0);
    ZC_ASSIGN(report.interior_faces, drop_interior(snapped, threads));
  }
  report.seconds.exterior = watch.lap();

  progress.begin("cut", 0.02, 0.05, 0);
  const double step_m = std::ldexp(1.0, options.step_log2);
  ZoneTree tree = cut_zones(snapped, options.leaf_triangles, leaf_step_shift(options.error_m, step_m));
  const std::vector<Material> materials = std::move(snapped.materials);
  report.notes = std::move(snapped.notes);
  WorldIndex& index = report.index;
  index.crs = std::move(snapped.crs);
  index.header.step_log2 = snapped.step_log2;
  index.header.anchor = snapped.anchor;
  textures.move_to_lattice(index.header.anchor, index.header.step_log2);
  snapped = {};
  report.seconds.cut = watch.lap();

  progress.begin("simplify", 0.05, 0.85, tree.zones.size());
  const std::vector<std::uint16_t> classes = appearance_classes(materials);
  const SimplifyContext context = {
      nullptr, materials, classes, step_m, options.error_m, options.leaf_triangles, options.atlas_size > 0};
  BakeCache cache;
  if (options.reuse) cache.read(writer.out() / kBakeCacheName);
  ProxyCache proxy_cache(cache, materials.size());
  ZC_ASSIGN(const ProxyTree proxies, build_proxies(std::move(tree), context, proxy_cache, [&] { progress.step(); }));
  report.proxies_reused = proxy_cache.found();
  report.proxies_built = proxy_cache.added();
  if (proxies.lost_triangles > 0)
    report.notes.push_back({"triangles without area at their zone's step, dropped", proxies.lost_triangles});
  if (proxies.coarse_zones > 0)
    report.notes.push_back({"zones too wide for the error bound, at full detail too", proxies.coarse_zones});
  if (proxies.bounded_zones > 0)
    report.notes.push_back({"zones whose simplification ended at its bound of work", proxies.bounded_zones});
  report.simplify_work = proxies.work;
  report.seconds.simplify = watch.lap();

  const std::size_t count = proxies.nodes.size();
  progress.begin("encode", 0.85, 0.92, count);
  std::set<std::uint32_t> depths;
  for (const ProxyNode& node : proxies.nodes) depths.insert(node.depth);
  for (const std::uint32_t depth : depths) ZC_TRY(writer.make_directory("zones/" + std::to_string(depth)));
  index.nodes.resize(count);
  std::vector<ZoneMesh> decoded(count);
  std::vector<DiskParts> disk(count);
  ZC_TRY(for_all(count, [&](std::size_t i) {
    Status status = encode_node(proxies.nodes[i], materials, step_m, writer, index.nodes[i], decoded[i], disk[i]);
    progress.step();
    return status;
  }));
  report.seconds.encode = watch.lap();

  std::vector<ZoneAppearance> appearances(count);
  const auto for_each_node = [&](const auto& work) {
    tbb::parallel_for(
        tbb::blocked_range<std::size_t>(0, count, 1),
        [&](const auto& range) {
          for (std::size_t i = range.begin(); i != range.end(); ++i) {
            work(i);
            progress.step();
          }
        },
        tbb::simple_partitioner());
  };
  LeftOutInput left_out = {report.interior_faces, proxies.left_out, proxies.left_out_triangles, options.light, {}};
  if (options.atlas_size > 0)
    for (const std::uint32_t height : heights(index.nodes))
      left_out.atlas_sizes.push_back(std::max(options.atlas_size >> height, kSmallestAtlas));
  if (!textures.empty() && options.atlas_size > 0) {
    progress.begin("atlas", 0.92, 0.93, count);
    for_each_node([&](std::size_t i) {
      const AtlasOptions atlas{.max_size = left_out.atlas_sizes[i]};
      appearances[i] = make_zone_appearance(decoded[i], index.nodes[i], textures, materials, step_m, atlas);
    });
  }
  report.seconds.atlas = watch.lap();

  if (options.light) {
    progress.begin("light", 0.93, 0.95, count);
    ZC_ASSIGN(CityLight light, light_city(decoded, index.nodes, materials, options.sun, step_m, threads, cache,
                                          [&] { progress.step(); }));
    for (std::size_t i = 0; i < count; ++i) appearances[i].light = std::move(light.zones[i]);
    report.lights_reused = light.reused;
    report.lights_built = light.built;
    if (options.sun) index.header.sun = options.sun->pack();
  }
  if (options.reuse) ZC_TRY(writer.write(kBakeCacheName, cache.encode()));
  report.seconds.light = watch.lap();

  progress.begin("bvh", 0.95, 1.0, count);
  const auto material_count = static_cast<std::uint32_t>(materials.size());
  ZC_TRY(for_all(count, [&](std::size_t i) {
    Status status = build_node_bvh(decoded[i], std::move(appearances[i]), options.bvh, material_count, writer,
                                   index.nodes[i], disk[i]);
    decoded[i] = {};
    progress.step();
    return status;
  }));
  report.seconds.bvh = watch.lap();

  for (std::size_t i = 0; i < count; ++i) (index.nodes[i].is_detail() ? report.detail : report.proxies).add(disk[i]);
  LatticeBox bounds;
  for (const NodeRecord& node : index.nodes) {
    bounds.add(node.bounds_min);
    bounds.add(node.bounds_max);
  }
  index.header.bounds_min = bounds.min;
  index.header.bounds_max = bounds.max;
  index.header.node_count = static_cast<std::uint32_t>(count);
  index.header.material_count = material_count;
  index.header.crs_bytes = static_cast<std::uint32_t>(index.crs.size());
  index.materials = material_records(materials);
  report.left_out = count_left_out(index, report.proxies, report.detail, left_out);
  ZC_TRY(writer.write(kWorldIndexName, encode_world_index(index)));
  ZC_TRY(writer.write_text("tileset.json", make_tileset_json(index)));
  report.seconds.total = import_s + all.lap();
  report.peak_rss_bytes = peak_rss_bytes();
  ZC_TRY(writer.write_text(kBakeReportName, bake_json(report)));
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
  std::optional<Result<BakeReport>> report;
  arena.execute([&] { report.emplace(bake(std::move(scene), import_s, options, writer)); });
  if (!report->ok()) return *std::move(report);
  ZC_TRY(writer.commit());
  return *std::move(report);
}

}  // namespace zc
