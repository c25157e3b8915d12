// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/light/city_light.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstring>
#include <glm/common.hpp>
#include <limits>
#include <map>
#include <mutex>

#include "baker/light/light_threads.h"

namespace zc {
namespace {

// One more whenever the light or an entry's form changes: what was kept before is stale then.
constexpr std::uint32_t kVersion = 8;
// Beyond what rays reach from within a box, for all roundings on the way.
constexpr float kMarginM = 1;

struct Box {
  glm::vec3 low{std::numeric_limits<float>::infinity()};
  glm::vec3 high{-std::numeric_limits<float>::infinity()};

  void add(const Box& b) {
    low = glm::min(low, b.low);
    high = glm::max(high, b.high);
  }
  [[nodiscard]] Box grown(float by) const { return {low - by, high + by}; }
  [[nodiscard]] bool touches(const Box& b) const {
    return glm::all(glm::lessThanEqual(low, b.high)) && glm::all(glm::greaterThanEqual(high, b.low));
  }
  // Whether a point of it that moves in this direction for ever comes to `b`.
  [[nodiscard]] bool reaches(const Box& b, const glm::vec3& direction) const {
    float from = 0;
    float to = std::numeric_limits<float>::infinity();
    for (int axis = 0; axis < 3; ++axis) {
      // Apart as long as low + d t > b.high or high + d t < b.low.
      const float d = direction[axis];
      const float first = b.low[axis] - high[axis];
      const float last = b.high[axis] - low[axis];
      if (std::abs(d) < 1e-9F) {
        if (first > 0 || last < 0) return false;
        continue;
      }
      from = std::max(from, std::min(first / d, last / d));
      to = std::min(to, std::max(first / d, last / d));
    }
    return from <= to;
  }
};

Box box_of(const NodeRecord& node, double step_m) {
  Box box;
  for (int axis = 0; axis < 3; ++axis) {
    const auto at = static_cast<std::size_t>(axis);
    box.low[axis] = static_cast<float>(node.bounds_min[at] * step_m);
    box.high[axis] = static_cast<float>(node.bounds_max[at] * step_m);
  }
  return box.grown(kMarginM + (node.is_detail() ? 0.0F
                                                : node.error_max_m + static_cast<float>(std::ldexp(
                                                                         step_m, static_cast<int>(node.step_shift)))));
}

// Nodes that are lit over one scene: those below one node that is about as wide as rays of light reach, or one node
// above those.
struct Region {
  std::vector<std::uint32_t> nodes;
  Box box;
  LightFrame frame;
};

std::vector<Region> make_regions(std::span<const NodeRecord> nodes, double step_m) {
  std::vector<Box> boxes;
  LatticeBox all;  // without errors: the city is not to be divided anew when one of them changes
  for (const NodeRecord& node : nodes) {
    boxes.push_back(box_of(node, step_m));
    all.add(LatticeBox{node.bounds_min, node.bounds_max});
  }
  const std::int64_t steps = std::max(std::int64_t{all.max[0]} - all.min[0], std::int64_t{all.max[1]} - all.min[1]);
  std::uint32_t depth = 0;
  for (double width = static_cast<double>(steps) * step_m; width > 2 * kLightReachM; width /= 2) ++depth;
  std::vector<std::uint32_t> region_of(nodes.size());
  std::vector<Region> regions;
  for (std::uint32_t i = 0; i < nodes.size(); ++i) {  // children lie behind their parents
    const NodeRecord& node = nodes[i];
    const bool below = node.parent >= 0 && node.depth > depth;
    // The detail of a leaf goes with the leaf.
    if (below || (node.parent >= 0 && node.is_detail())) {
      region_of[i] = region_of[static_cast<std::size_t>(node.parent)];
    } else {
      region_of[i] = static_cast<std::uint32_t>(regions.size());
      regions.emplace_back();
    }
    regions[region_of[i]].nodes.push_back(i);
    regions[region_of[i]].box.add(boxes[i]);
  }
  return regions;
}

template <class T>
std::span<const std::byte> bytes_of(const std::vector<T>& values, std::size_t first, std::size_t count) {
  return std::as_bytes(std::span(values).subspan(first, count));
}

class CityLighter {
 public:
  CityLighter(const LightInput& input, BakeContext& context)
      : meshes_(input.meshes),
        nodes_(input.nodes),
        sun_(input.sun),
        step_m_(input.step_m),
        cache_(input.cache),
        context_(context),
        detail_(meshes_, nodes_, input.materials, step_m_),
        regions_(make_regions(nodes_, step_m_)),
        part_of_(nodes_.size()) {
    for (std::uint32_t p = 0; p < detail_.parts.size(); ++p) {
      const LightDetail::Part& part = detail_.parts[p];
      part_of_[part.node] = p;
      const std::size_t first = 3 * std::size_t{part.first};
      const std::size_t count = 3 * std::size_t{part.count};
      CacheKeyHasher hash;
      hash.add(bytes_of(detail_.corners, first, count)).add(bytes_of(detail_.albedo, part.first, part.count));
      if (!detail_.exact.empty()) hash.add(bytes_of(detail_.exact, first, count));
      part_keys_.push_back(hash.key());
    }
    for (Region& region : regions_) region.frame = LightFrame::around(detail_, region.box.low, region.box.high);
  }

  Result<CityLight> run() {
    ZC_ASSIGN(const LightDevice device, LightDevice::create());
    device_ = &device;
    ZC_TRY(measure_sunlight());
    for (const LightDetail::Part& part : detail_.parts)
      sunlight_keys_.push_back(CacheKeyHasher().add(bytes_of(detail_.sunlight, part.first, part.count)).key());
    ZC_TRY(light_nodes());
    return std::move(out_);
  }

 private:
  // A node to be worked on, over the scene of its region's parts.
  struct Work {
    std::uint32_t region = 0;
    std::uint32_t node = 0;
    CacheKey key = {};
  };
  // Built by the first who needs it, gone with the last.
  struct SharedScene {
    std::once_flag once;
    std::optional<Result<LightScene>> scene;
    std::atomic<std::size_t> left = 0;
  };

  CacheKeyHasher common(std::uint32_t what, const LightFrame& frame) const {
    CacheKeyHasher hash;
    hash.add(kVersion).add(what).add(step_m_).add(frame.bias_m);
    if (!detail_.exact.empty()) hash.add(frame.origin.x).add(frame.origin.y).add(frame.origin.z);
    return hash;
  }

  // Parts that rays from a region's box can hit: none further than this, or all in these directions.
  [[nodiscard]] std::vector<std::uint32_t> parts_near(const Box& box, float reach_m,
                                                      std::span<const glm::vec3> directions) const {
    const Box near = box.grown(reach_m);
    std::vector<std::uint32_t> out;
    for (std::uint32_t p = 0; p < detail_.parts.size(); ++p) {
      const Box part = {detail_.parts[p].low, detail_.parts[p].high};
      if (near.touches(part) ||
          std::ranges::any_of(directions, [&](const glm::vec3& d) { return box.reaches(part, d); }))
        out.push_back(p);
    }
    return out;
  }

  Status measure_sunlight() {
    std::vector<Work> work;
    std::vector<std::vector<std::uint32_t>> parts(regions_.size());
    for (std::uint32_t r = 0; r < regions_.size(); ++r) {
      const Region& region = regions_[r];
      if (std::ranges::none_of(region.nodes, [&](std::uint32_t n) { return nodes_[n].is_detail(); })) continue;
      parts[r] = parts_near(region.box, 0, bounce_suns());
      CacheKeyHasher around = common(0, region.frame);
      for (const std::uint32_t p : parts[r]) around.add(std::span<const std::uint64_t>(part_keys_[p]));
      const CacheKey around_key = around.key();
      for (const std::uint32_t node : region.nodes) {
        if (!nodes_[node].is_detail()) continue;
        const std::uint32_t p = part_of_[node];
        const CacheKey key = CacheKeyHasher()
                                 .add(std::span<const std::uint64_t>(around_key))
                                 .add(std::span<const std::uint64_t>(part_keys_[p]))
                                 .key();
        const LightDetail::Part& part = detail_.parts[p];
        const auto known = cache_.find(key);
        if (known && known->size() == part.count * sizeof(LightDetail::Sunlight)) {
          if (part.count > 0) std::memcpy(detail_.sunlight.data() + part.first, known->data(), known->size());
        } else {
          work.push_back({r, node, key});
        }
      }
    }
    return for_each_work(work, parts, [&](const Work& w, const LightScene& scene) {
      const LightDetail::Part& part = detail_.parts[part_of_[w.node]];
      for (std::uint32_t t = part.first; t < part.first + part.count; ++t)
        detail_.sunlight[t] = scene.measure_sunlight(t);
      const auto bytes = bytes_of(detail_.sunlight, part.first, part.count);
      cache_.add(w.key, {bytes.begin(), bytes.end()});
    });
  }

  Status light_nodes() {
    out_.zones.resize(nodes_.size());
    std::vector<glm::vec3> suns;
    if (sun_) suns.push_back(sun_direction(*sun_));
    std::vector<Work> work;
    std::vector<std::vector<std::uint32_t>> parts(regions_.size());
    for (std::uint32_t r = 0; r < regions_.size(); ++r) {
      parts[r] = parts_near(regions_[r].box, kLightReachM, suns);
      CacheKeyHasher around = common(1, regions_[r].frame);
      for (const glm::vec3& s : suns) around.add(s.x).add(s.y).add(s.z);
      for (const std::uint32_t p : parts[r])
        around.add(std::span<const std::uint64_t>(part_keys_[p]))
            .add(std::span<const std::uint64_t>(sunlight_keys_[p]));
      const CacheKey around_key = around.key();
      for (const std::uint32_t n : regions_[r].nodes) {
        const NodeRecord& node = nodes_[n];
        const CacheKey key = CacheKeyHasher()
                                 .add(std::span<const std::uint64_t>(around_key))
                                 .add(std::as_bytes(std::span(meshes_[n].vertices)))
                                 .add(std::as_bytes(std::span(meshes_[n].triangles)))
                                 .add(std::span<const std::int32_t>(node.origin))
                                 .add(std::uint32_t{node.step_shift})
                                 .add(std::uint32_t{node.is_detail()})
                                 .add(node.error_max_m)
                                 .key();
        if (find_light(key, meshes_[n].triangles.size(), out_.zones[n])) {
          ++out_.reused;
          context_.step();
        } else {
          work.push_back({r, n, key});
        }
      }
    }
    out_.built = work.size();
    return for_each_work(work, parts, [&](const Work& w, const LightScene& scene) {
      out_.zones[w.node] = bake_zone_light(meshes_[w.node], nodes_[w.node], scene, sun_, step_m_);
      const auto bytes = std::as_bytes(std::span(out_.zones[w.node]));
      cache_.add(w.key, {bytes.begin(), bytes.end()});
      context_.step();
    });
  }

  // False where the cache has nothing that could be light of so many triangles.
  bool find_light(const CacheKey& key, std::size_t triangles, std::vector<gpu::TriangleLight>& light) const {
    const auto known = cache_.find(key);
    if (!known || (!known->empty() && known->size() != triangles * sizeof(gpu::TriangleLight))) return false;
    light.resize(known->size() / sizeof(gpu::TriangleLight));
    if (!light.empty()) std::memcpy(light.data(), known->data(), known->size());
    const bool sound = std::ranges::all_of(
        light, [](const gpu::TriangleLight& l) { return (l.bounce >> 22U & 3U) <= gpu::kSunShadow; });
    if (!sound) light.clear();
    return sound;
  }

  // Work comes region by region; parts: of each region.
  template <class Function>
  Status for_each_work(const std::vector<Work>& work, const std::vector<std::vector<std::uint32_t>>& parts,
                       const Function& function) {
    std::map<std::uint32_t, SharedScene> scenes;
    for (const Work& w : work) ++scenes[w.region].left;
    std::mutex mutex;
    std::optional<Error> failed;
    for_each_on_threads(work.size(), context_.threads(), [&](std::size_t i) {
      SharedScene& shared = scenes.at(work[i].region);
      std::call_once(shared.once, [&] {
        shared.scene.emplace(
            LightScene::build(*device_, detail_, parts[work[i].region], regions_[work[i].region].frame));
        const std::lock_guard lock(mutex);
        if (!shared.scene->ok() && !failed) failed = shared.scene->error();
      });
      if (shared.scene->ok()) function(work[i], **shared.scene);
      if (--shared.left == 0) shared.scene.reset();
    });
    if (failed) return *std::move(failed);
    return {};
  }

  std::span<const ZoneMesh> meshes_;
  std::span<const NodeRecord> nodes_;
  const std::optional<SunAngles>& sun_;
  double step_m_;
  BakeCache& cache_;
  BakeContext& context_;
  LightDetail detail_;
  std::vector<Region> regions_;
  std::vector<std::uint32_t> part_of_;  // per node, where it is a detail
  std::vector<CacheKey> part_keys_;     // of its triangles and their colours
  std::vector<CacheKey> sunlight_keys_;
  const LightDevice* device_ = nullptr;
  CityLight out_;
};

}  // namespace

Result<CityLight> light_city(LightInput&& input, BakeContext& context) {
  context.begin(BakeStage::kLight, input.nodes.size());
  return CityLighter(input, context).run();
}

}  // namespace zc
