// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <cmath>
#include <iostream>
#include <memory>
#include <optional>

#include "baker/bvh/build_page.h"
#include "baker/bvh/simulate.h"
#include "replay/bench/build_bench.h"
#include "replay/bench/engines/embree_builder.h"
#include "replay/bench/engines/parallel_chunks.h"
#include "replay/bench/engines/zone_mesh.h"
#include "replay/cli/bench/bench_subject.h"
#include "replay/cli/commands.h"
#include "replay/cli/json_option.h"
#include "replay/cli/progress.h"
#include "replay/cli/world_option.h"
#include "shaders/shared/page_node.h"

namespace zc {
namespace {

using bench::EmbreeOptions;
using bench::EmbreeQuality;
using bench::PeerNode;
using bench::TreeBuilder;
using bench::TreeFigures;
using bench::TreeProbe;

struct Arguments {
  WorldOption world;
  bench::SubjectOptions subject;
  bool thesis = false;
  bench::BuildBenchOptions options;
  JsonOption json;
};

// The thesis's city: Fredriksson & Scott 2016, table 4.1.
constexpr std::size_t kThesisZones = 167;
constexpr std::size_t kThesisTriangles = 627'411;

constexpr std::uint32_t kJudgeRays = 1024;  // behind those that `auto` chooses by

struct Zone {
  ZoneMesh mesh;
  NodeRecord node;
  std::vector<BvhTriangle> triangles;
  std::vector<std::array<std::array<float, 3>, 3>> corners;  // the same, for Embree
  std::vector<SampleRay> rays;
  std::vector<SampleHit> hits;  // the nearest, by testing every triangle
};

Zone make_zone(const bench::BenchScene& scene, const bench::BenchZone& place) {
  Zone zone;
  zone.mesh = bench::weld_zone(scene, place, zone.node);
  zone.triangles = bvh_triangles(zone.mesh);
  for (const BvhTriangle& t : zone.triangles) {
    auto& corners = zone.corners.emplace_back();
    for (std::size_t i = 0; i < 9; ++i) corners[i / 3][i % 3] = t[i / 3][i % 3];
  }
  zone.rays = make_sample_rays(zone.triangles, kSampleRays + kJudgeRays);
  zone.rays.erase(zone.rays.begin(), zone.rays.begin() + kSampleRays);
  for (const SampleRay& ray : zone.rays) {
    SampleHit& hit = zone.hits.emplace_back();
    for (std::uint32_t i = 0; i < zone.triangles.size(); ++i) test_triangle(zone.triangles[i], i, ray, hit);
  }
  return zone;
}

double sah_cost(const WideTree& tree) {
  double cost = 0;
  BvhBox root;
  for (const WideChild& child : tree.nodes[0].slots) root.add(child.box);
  cost += kNodeVisitCost * static_cast<double>(root.half_area());
  for (const WideNode& node : tree.nodes) {
    for (const WideChild& child : node.slots) {
      const auto area = static_cast<double>(child.box.half_area());
      if (child.kind == WideChild::Kind::kNode) cost += kNodeVisitCost * area;
      if (child.kind == WideChild::Kind::kLeaf) cost += kTriangleTestCost * area * child.count;
    }
  }
  return cost / static_cast<double>(std::max<std::int64_t>(1, root.half_area()));
}

Result<TreeFigures> look_at(const WideTree& tree, const Zone& zone) {
  TreeFigures figures;
  figures.nodes = tree.nodes.size();
  figures.references = tree.references.size();
  figures.depth = tree.depth;
  NodeRecord node = zone.node;
  ZC_ASSIGN(const BuiltPage page, lay_out_page(tree, zone.mesh, {}, 1, node, "page"));
  figures.page_bytes = 4 * page.words.size();
  figures.sah_cost = sah_cost(tree);
  const TreeSimulation simulation(tree, zone.triangles);
  TraceCounts counts;
  for (std::size_t i = 0; i < zone.rays.size(); ++i) {
    const SampleHit hit = simulation.trace(zone.rays[i], counts);
    if (hit.triangle != zone.hits[i].triangle) ++figures.mismatches;
  }
  figures.ray_cost = mean_cost(counts, zone.rays.size());
  return figures;
}

TreeBuilder make_own(std::string_view name, BvhMethod method, const std::vector<Zone>& zones) {
  BvhBuildOptions options;
  options.method = method;
  const auto build = [options, &zones](std::size_t i) -> Result<TreeProbe> {
    ZC_ASSIGN(WideTree tree, build_wide_bvh(zones[i].triangles, options));
    return TreeProbe([tree = std::move(tree), &zone = zones[i]] { return look_at(tree, zone); });
  };
  return {"zonecast/" + std::string(name), build};
}

// On the zone's lattice, around all of what it was.
BvhBox lattice_box(const bench::PeerBox& box) {
  const auto on_lattice = [](float v) { return static_cast<std::uint16_t>(std::clamp(v, 0.0F, 65535.0F)); };
  BvhBox out;
  for (std::size_t i = 0; i < 3; ++i) {
    out.min[i] = on_lattice(std::floor(box.min[i]));
    out.max[i] = on_lattice(std::ceil(box.max[i]));
  }
  return out;
}

BvhBox bounds_of(const PeerNode& node) {
  BvhBox box;
  for (std::uint32_t i = 0; i < node.child_count; ++i) box.add(lattice_box(node.boxes[i]));
  for (const bench::PeerReference& r : node.references) box.add(lattice_box(r.box));
  return box;
}

// Nodes of two children and leaves of one reference.
BinaryTree binary_tree(const std::vector<PeerNode>& nodes) {
  BinaryTree tree;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> todo = {{0, 0}};  // Embree's node, ours
  tree.nodes.emplace_back();
  while (!todo.empty()) {
    const auto [from, to] = todo.back();
    todo.pop_back();
    const PeerNode& node = nodes[from];
    tree.nodes[to].box = bounds_of(node);
    if (node.child_count == 0) {
      const bench::PeerReference& r = node.references.at(0);
      tree.nodes[to].reference = static_cast<std::uint32_t>(tree.references.size());
      tree.references.push_back({lattice_box(r.box), r.triangle});
      continue;
    }
    const auto left = static_cast<std::uint32_t>(tree.nodes.size());
    tree.nodes[to].left = left;
    tree.nodes.resize(tree.nodes.size() + 2);
    todo.emplace_back(node.children[1], left + 1);
    todo.emplace_back(node.children[0], left);
  }
  return tree;
}

// Nodes of up to eight children as they are; children go to slots by octant, as our own do.
class WideCopy {
 public:
  explicit WideCopy(const std::vector<PeerNode>& nodes) : nodes_(nodes) {
    tree_.nodes.emplace_back();
    copy(0, 0, 1);
  }
  WideTree take() && { return std::move(tree_); }

 private:
  void copy(std::uint32_t from, std::uint32_t to, std::uint32_t depth) {
    tree_.depth = std::max(tree_.depth, depth);
    const PeerNode& node = nodes_[from];
    std::array<NodeBox, gpu::kNodeWidth> boxes;
    const std::uint32_t count = std::max(1U, node.child_count);  // a tree that is one leaf: that
    for (std::uint32_t i = 0; i < count; ++i) {
      const BvhBox box = node.child_count > 0 ? lattice_box(node.boxes[i]) : bounds_of(node);
      boxes[i] = {{box.min[0], box.min[1], box.min[2]}, {box.max[0], box.max[1], box.max[2]}};
    }
    const auto child_of_slot = assign_slots(std::span(boxes).first(count));
    std::vector<std::pair<std::uint32_t, std::uint32_t>> inner;
    for (std::size_t slot = 0; slot < gpu::kNodeWidth; ++slot) {
      if (child_of_slot[slot] < 0) continue;
      const auto i = static_cast<std::size_t>(child_of_slot[slot]);
      const std::uint32_t peer = node.child_count > 0 ? node.children[i] : from;
      WideChild& child = tree_.nodes[to].slots[slot];
      for (std::size_t axis = 0; axis < 3; ++axis) {
        child.box.min[axis] = static_cast<std::uint16_t>(boxes[i].min[axis]);
        child.box.max[axis] = static_cast<std::uint16_t>(boxes[i].max[axis]);
      }
      if (nodes_[peer].child_count == 0) {
        child.kind = WideChild::Kind::kLeaf;
        child.first = static_cast<std::uint32_t>(tree_.references.size());
        for (const bench::PeerReference& r : nodes_[peer].references) {
          const auto known = std::find_if(tree_.references.begin() + child.first, tree_.references.end(),
                                          [&](const BvhReference& have) { return have.triangle == r.triangle; });
          if (known == tree_.references.end()) {
            tree_.references.push_back({lattice_box(r.box), r.triangle});
          } else {
            known->box.add(lattice_box(r.box));
          }
        }
        child.count = static_cast<std::uint32_t>(tree_.references.size()) - child.first;
      } else {
        child.kind = WideChild::Kind::kNode;
        child.first = static_cast<std::uint32_t>(tree_.nodes.size() + inner.size());
        inner.emplace_back(peer, child.first);
      }
    }
    tree_.nodes.resize(tree_.nodes.size() + inner.size());
    for (const auto& [peer, own] : inner) copy(peer, own, depth + 1);
  }

  const std::vector<PeerNode>& nodes_;
  WideTree tree_;
};

// What Embree builds is timed; its conversion is not. width 2: collapsed by our own programme.
TreeBuilder make_peer(std::string name, EmbreeOptions options, bench::EmbreeBuilder* embree,
                      const std::vector<Zone>& zones) {
  if (embree == nullptr) return {std::move(name), {}, "built without Embree 3"};
  const auto build = [=, &zones](std::size_t i) -> Result<TreeProbe> {
    ZC_ASSIGN(std::unique_ptr<bench::EmbreeTree> built, embree->build(zones[i].corners, options));
    return TreeProbe([built = std::shared_ptr<bench::EmbreeTree>(std::move(built)), &zone = zones[i], options] {
      const std::vector<PeerNode> nodes = built->nodes();
      return look_at(options.width == 2 ? collapse(binary_tree(nodes), {}) : WideCopy(nodes).take(), zone);
    });
  };
  return {std::move(name), build};
}

// So many of the scene's zones, cut to so many triangles in all.
Result<bench::BenchScene> thesis_scene(bench::BenchScene&& scene) {
  const std::size_t each = (kThesisTriangles + kThesisZones - 1) / kThesisZones;
  bench::BenchScene out;
  out.name = "thesis_627k";
  out.step_m = scene.step_m;
  for (const bench::BenchZone& zone : scene.zones) {
    const std::size_t left = kThesisTriangles - out.triangles.size();
    const auto count = static_cast<std::uint32_t>(std::min(each, left));
    if (count == 0 || zone.count < count) continue;
    out.zones.push_back({static_cast<std::uint32_t>(out.triangles.size()), count, zone.step_shift});
    const auto first = scene.triangles.begin() + zone.first;
    out.triangles.insert(out.triangles.end(), first, first + count);
  }
  if (out.triangles.size() != kThesisTriangles || out.zones.size() != kThesisZones)
    return Error{ErrorCode::kFormat, "the generated city has too few zones for the thesis's case"};
  return out;
}

Status run(const Arguments& a) {
  if (a.thesis && !(a.world.place.empty() && a.subject.triangles.empty()))
    return Error{ErrorCode::kArgument, "--thesis makes its own scene; leave out the world and --triangles"};
  if (!a.world.place.empty() && !a.subject.triangles.empty())
    return Error{ErrorCode::kArgument, "a world and --triangles: one of them names the scene"};
  std::vector<Zone> zones;  // which the builders look at
  std::vector<TreeBuilder> builders;
  for (const BvhMethodName& method : bvh_methods()) builders.push_back(make_own(method.name, method.method, zones));
  const auto embree = bench::make_embree_builder(a.options.threads);
  constexpr std::uint32_t kLeaf = gpu::kNodeMaxTriangles / gpu::kNodeWidth;
  constexpr std::array kQualities = {std::pair("morton", EmbreeQuality::kMorton), std::pair("sah", EmbreeQuality::kSah),
                                     std::pair("sbvh", EmbreeQuality::kSplits)};
  for (const auto& [name, quality] : kQualities)  // as Embree makes wide nodes
    builders.push_back(
        make_peer("embree/" + std::string(name), {quality, gpu::kNodeWidth, kLeaf}, embree.get(), zones));
  for (const auto& [name, quality] : kQualities)
    builders.push_back(make_peer("embree/" + std::string(name) + "+collapse", {quality, 2, 1}, embree.get(), zones));
  ZC_TRY(bench::check_builders(builders, a.options.engines));

  bench::SubjectOptions source = a.subject;
  source.world = a.world.place;
  ZC_ASSIGN(source.source, parse_source_options(a.world));
  if (a.thesis) {
    source.size_km = 3;
    source.leaf_triangles = 8000;
  }
  ZC_ASSIGN(bench::Subject subject, bench::open_subject(source));
  if (a.thesis) {
    ZC_ASSIGN(subject.scene, thesis_scene(std::move(subject.scene)));
  }
  zones.resize(subject.scene.zones.size());
  bench::parallel_chunks<1>(zones.size(), a.options.threads, [&](std::size_t i, std::size_t /*end*/) {
    zones[i] = make_zone(subject.scene, subject.scene.zones[i]);
  });

  bench::BuildBenchOptions options = a.options;
  std::optional<Progress> progress(std::in_place);
  options.progress = [&](double fraction, std::string_view stage) { progress->update(fraction, stage); };
  ZC_ASSIGN(
      const bench::BuildBenchReport report,
      bench::run_build_bench(subject.scene.name, subject.scene.triangles.size(), zones.size(), builders, options));
  progress.reset();  // its line goes before the table comes
  if (!a.json.replaces_text()) std::cout << bench::build_table(report);
  return write_json(a.json, bench::build_json(report).dump(2));
}

}  // namespace

void add_bench_build(CLI::App& app, const SetCommand& set) {
  const auto a = std::make_shared<Arguments>();
  CLI::App* command = app.add_subcommand(
      "build", "Build the trees of the same zones with our builders and Embree's, and trace the same rays in each");
  add_world_option(*command, a->world, "without it and --triangles: the generated city");
  command->add_option("--triangles", a->subject.triangles, "Raw floats, nine a triangle");
  command->add_flag("--thesis", a->thesis, "The thesis's size: 627,411 triangles in 167 zones of a generated city");
  command->add_option("--engines", a->options.engines, "Separated by commas; default: all that this machine has")
      ->delimiter(',');
  command->add_option("--repeat", a->options.repeat, "Timed runs of each engine, in turn")
      ->capture_default_str()
      ->check(CLI::Range(1U, 1000U));
  command->add_option("--threads", a->options.threads, "Threads")->capture_default_str()->check(CLI::Range(1U, 256U));
  add_json_option(*command, a->json);
  command->callback([=] { set([=] { return run(*a); }); });
}

}  // namespace zc
