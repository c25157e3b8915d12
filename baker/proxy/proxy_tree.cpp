// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/proxy/proxy_tree.h"

#include <algorithm>
#include <atomic>
#include <memory>
#include <optional>

#include "baker/proxy/proxy_cache.h"

namespace zc {
namespace {

struct ZoneState {
  CacheKey key = {};           // of the proxy
  Proxy detail;                // of a leaf: rounded
  DistanceBvh bvh;             // of a leaf: over the unrounded detail; empty until something is measured against it
  std::optional<Proxy> proxy;  // none: not stored
  std::vector<std::uint32_t> below;   // stored zones that attach here, or pass through when this one is not stored
  std::vector<std::uint32_t> leaves;  // stored leaves in this zone
};

// Leaf zones of one parent, which may become one.
struct Group {
  std::vector<std::uint32_t> zones;
  LatticeBox box;  // of the detail
  std::size_t detail_faces = 0;
  std::size_t proxy_faces = 0;
  bool textured = false;

  // One atlas serves one of them, and no detail is rounded to a longer step than now.
  [[nodiscard]] bool may_take(const Group& o, std::size_t leaf_triangles) const {
    LatticeBox joint = box;
    joint.add(o.box);
    const std::uint32_t shift = step_shift_for_box(joint);
    return proxy_faces + o.proxy_faces <= leaf_triangles &&
           detail_faces + o.detail_faces <= kDetailZonesLimit * leaf_triangles && !(textured && o.textured) &&
           step_shift_for_box(box) == shift && step_shift_for_box(o.box) == shift;
  }
  void take(const Group& o) {
    zones.insert(zones.end(), o.zones.begin(), o.zones.end());
    box.add(o.box);
    detail_faces += o.detail_faces;
    proxy_faces += o.proxy_faces;
    textured = textured || o.textured;
  }
};

class Builder {
 public:
  Builder(ZoneTree&& tree, const SimplifyContext& context, ProxyCache& cache, BakeContext& bake)
      : tree_(std::move(tree)), context_(context), cache_(cache), bake_(bake), states_(tree_.zones.size()) {}

  Result<ProxyTree> run() {
    std::uint32_t deepest = 0;
    for (const Zone& zone : tree_.zones) deepest = std::max(deepest, zone.depth);
    // Leaves are independent; inner zones wait for those below.
    for_zones([this](std::size_t i) { return tree_.zones[i].children.empty(); },
              [this](std::size_t i) { build_leaf(i); });
    merge_leaves();
    for (std::uint32_t depth = deepest; depth-- > 0;) {
      const auto is_inner = [&](std::size_t i) {
        return tree_.zones[i].depth == depth && !tree_.zones[i].children.empty();
      };
      for_zones(is_inner, [this](std::size_t i) { build_inner(i); });
    }
    if (!states_[0].proxy) return Error{ErrorCode::kFormat, "no triangle survives the rounding to its zone's step"};
    return collect();
  }

 private:
  template <class Select, class Build>
  void for_zones(Select select, Build build) {
    std::vector<std::size_t> chosen;
    for (std::size_t i = 0; i < tree_.zones.size(); ++i)
      if (select(i)) chosen.push_back(i);
    [[maybe_unused]] const Status done = bake_.for_each(chosen.size(), [&](std::size_t i) -> Status {
      build(chosen[i]);
      return {};
    });
  }

  void build_leaf(std::size_t i) {
    const Zone& zone = tree_.zones[i];
    ZoneState& state = states_[i];
    state.detail = round_detail(zone.detail);
    if (state.detail.mesh.faces.empty()) return;
    state.leaves = {static_cast<std::uint32_t>(i)};
    state.key = leaf_key(context_, zone);
    if (auto known = cache_.find(state.key); known && *known) {
      state.proxy = *std::move(known);
    } else {
      state.proxy = simplify_leaf(context_, zone, state.detail, detail_surface(i));
      work_ += state.proxy->work;
      cache_.add(state.key, state.proxy);
    }
    // What rounding moved. Refinement never raises the promised error.
    SurfaceError& moved = state.detail.error;
    moved.max_m = zone.most_moved() * context_.step_m;
    if (state.detail.step_shift == 0) return;
    const DetailSurface surface = detail_surface(i);
    moved = measure_proxy(state.detail.mesh, std::span(&surface, 1), context_.materials, context_.appearances,
                          context_.step_m);
    if (moved.is_loose && state.detail.mesh.faces.size() == zone.detail.faces.size())
      moved.max_m = std::min(
          moved.max_m, rounding_m(context_.step_m, state.detail.step_shift) + zone.most_moved() * context_.step_m);
    state.proxy->error.max_m = std::max(state.proxy->error.max_m, moved.max_m);
    state.proxy->error.appearance_m = std::max(state.proxy->error.appearance_m, moved.appearance_m);
  }

  static std::uint32_t index(std::size_t i) { return static_cast<std::uint32_t>(i); }

  Group group_of(std::uint32_t leaf) const {
    const LatticeMesh& detail = tree_.zones[leaf].detail;
    const bool textured = context_.atlases && std::ranges::any_of(detail.faces, [&](const LatticeFace& face) {
                            return context_.materials[face.material].texture.has_value();
                          });
    return {{leaf}, bounds_of(detail), detail.faces.size(), states_[leaf].proxy->mesh.faces.size(), textured};
  }

  // The cut goes by the detail's triangles, of which a proxy may need few: neighbours become one zone, in the place of
  // their parent when nothing else is below it, while their proxies together are within the size of one. The root
  // stays apart: it is always resident.
  void merge_leaves() {
    std::vector<std::optional<Group>> groups(tree_.zones.size());
    for (std::size_t i = tree_.zones.size(); i-- > 0;) {  // children lie behind their parents
      Zone& zone = tree_.zones[i];
      if (zone.children.empty()) {
        if (states_[i].proxy) groups[i] = group_of(index(i));
        continue;
      }
      std::vector<std::uint32_t> kept;
      for (const std::uint32_t child : zone.children) {
        const auto host = std::ranges::find_if(kept, [&](std::uint32_t other) {
          return groups[child] && groups[other] && groups[other]->may_take(*groups[child], context_.leaf_triangles);
        });
        if (host == kept.end()) {
          kept.push_back(child);
        } else {
          groups[*host]->take(*groups[child]);
          groups[child].reset();
        }
      }
      zone.children = std::move(kept);
      if (zone.parent < 0 || zone.children.size() > 1 || !groups[zone.children[0]]) continue;
      groups[i].swap(groups[zone.children[0]]);
      zone.children.clear();
    }
    const auto is_joint = [&](std::size_t i) { return groups[i] && groups[i]->zones != std::vector{index(i)}; };
    for_zones(is_joint, [&](std::size_t i) { join(groups[i]->zones, index(i)); });
  }

  // The proxies of the parts, side by side.
  void join(std::span<const std::uint32_t> parts, std::uint32_t into) {
    LatticeMesh joint;
    std::array<float, 2> moved = {};
    Proxy proxy;
    ErrorSum error, detail_error;
    for (const std::uint32_t part : parts) {
      LatticeMesh& detail = tree_.zones[part].detail;
      const Proxy& own = *states_[part].proxy;
      append(joint, detail);
      for (std::size_t g = 0; g < 2; ++g) moved[g] = std::max(moved[g], tree_.zones[part].moved[g]);
      append(proxy.mesh, own.mesh);
      proxy.step_shift = own.step_shift;
      proxy.is_bounded = proxy.is_bounded || own.is_bounded;
      error.add(own.error, area_of(detail));
      detail_error.add(states_[part].detail.error, area_of(detail));
      detail = {};
      states_[part] = {};
    }
    clean(joint);
    clean(proxy.mesh);
    proxy.error = error.joint();
    Zone& zone = tree_.zones[into];
    zone.detail = std::move(joint);
    zone.moved = moved;
    ZoneState& state = states_[into];
    state.detail = round_detail(zone.detail);
    state.detail.error = detail_error.joint();
    state.leaves = {into};
    state.key = leaf_key(context_, zone);
    state.proxy = std::move(proxy);
  }

  // One caller at a time for a leaf: inner zones of one depth have none in common.
  DetailSurface detail_surface(std::size_t leaf) {
    if (states_[leaf].bvh.empty()) states_[leaf].bvh = DistanceBvh(tree_.zones[leaf].detail, context_.appearances);
    return {&tree_.zones[leaf].detail, &states_[leaf].bvh, tree_.zones[leaf].most_moved()};
  }

  void build_inner(std::size_t i) {
    const Zone& zone = tree_.zones[i];
    ZoneState& state = states_[i];
    for (const std::uint32_t child : zone.children) {
      const ZoneState& below = states_[child];
      if (below.proxy) {
        state.below.push_back(child);
      } else {
        state.below.insert(state.below.end(), below.below.begin(), below.below.end());
      }
      state.leaves.insert(state.leaves.end(), below.leaves.begin(), below.leaves.end());
    }
    if (state.below.empty()) return;
    std::vector<const Proxy*> children;
    for (const std::uint32_t child : state.below) children.push_back(&*states_[child].proxy);
    std::vector<CacheKey> child_keys;
    for (const std::uint32_t child : state.below) child_keys.push_back(states_[child].key);
    std::vector<CacheKey> leaf_keys;
    for (const std::uint32_t leaf : state.leaves) leaf_keys.push_back(states_[leaf].key);
    state.key = inner_key(context_, zone, child_keys, leaf_keys);
    if (auto known = cache_.find(state.key); known && may_stand_above(*known, children)) {
      state.proxy = *std::move(known);
      return;
    }
    std::vector<DetailSurface> detail;
    for (const std::uint32_t leaf : state.leaves) detail.push_back(detail_surface(leaf));
    state.proxy = simplify_inner(context_, zone, children, detail);
    if (state.proxy) work_ += state.proxy->work;
    cache_.add(state.key, state.proxy);
  }

  // Refinement never raises the promised error, whatever a cache contains.
  static bool may_stand_above(const std::optional<Proxy>& proxy, std::span<const Proxy* const> children) {
    return !proxy || std::ranges::all_of(children, [&](const Proxy* child) {
      return child->error.max_m <= proxy->error.max_m && child->error.appearance_m <= proxy->error.appearance_m;
    });
  }

  ProxyTree collect() {
    ProxyTree out;
    std::uint64_t lost_triangles = 0;
    std::uint64_t coarse_zones = 0;
    for (std::size_t i = 0; i < tree_.zones.size(); ++i) {
      const Proxy& detail = states_[i].detail;
      if (!tree_.zones[i].children.empty()) continue;
      lost_triangles += tree_.zones[i].detail.faces.size() - detail.mesh.faces.size();
      if (detail.error.max_m > context_.error_m) ++coarse_zones;
    }
    const auto bounded_zones = static_cast<std::uint64_t>(
        std::ranges::count_if(states_, [](const ZoneState& state) { return state.proxy && state.proxy->is_bounded; }));
    const auto note = [&](const char* what, std::uint64_t count) {
      if (count > 0) out.notes.push_back({what, count});
    };
    note("triangles without area at their zone's step, dropped", lost_triangles);
    note("zones too wide for the error bound, at full detail too", coarse_zones);
    note("zones whose simplification ended at its bound of work", bounded_zones);
    out.reused = cache_.found();
    out.built = cache_.added();
    out.work = work_;
    std::vector<std::uint32_t> zone_of = {0};
    out.nodes.push_back(make_node(0, -1));
    for (std::size_t i = 0; i < out.nodes.size(); ++i) {
      if (out.nodes[i].is_detail) continue;
      const std::uint32_t zone = zone_of[i];
      const auto parent = static_cast<std::int32_t>(i);
      out.nodes[i].first_child = static_cast<std::uint32_t>(out.nodes.size());
      if (tree_.zones[zone].children.empty()) {
        ProxyNode detail = make_node(zone, parent);
        detail.is_detail = true;
        detail.proxy = std::move(states_[zone].detail);
        out.nodes[i].child_count = 1;
        out.nodes.push_back(std::move(detail));
        zone_of.push_back(zone);
        continue;
      }
      out.nodes[i].child_count = static_cast<std::uint32_t>(states_[zone].below.size());
      for (const std::uint32_t child : states_[zone].below) {
        out.nodes.push_back(make_node(child, parent));
        zone_of.push_back(child);
      }
    }
    for (const ZoneState& state : states_) {
      if (state.proxy || state.below.empty()) continue;
      ++out.left_out;
      std::size_t below = 0;
      for (const std::uint32_t child : state.below) below += states_[child].proxy->mesh.faces.size();
      out.left_out_triangles += static_cast<std::uint64_t>(kStoredAtMost * static_cast<double>(below));
    }
    // Moved last: until here, children are read through their zones.
    for (std::size_t i = 0; i < out.nodes.size(); ++i)
      if (!out.nodes[i].is_detail) out.nodes[i].proxy = std::move(*states_[zone_of[i]].proxy);
    return out;
  }

  ProxyNode make_node(std::uint32_t zone, std::int32_t parent) const {
    ProxyNode node;
    node.parent = parent;
    node.depth = tree_.zones[zone].depth;
    node.cell_x = tree_.zones[zone].cell_x;
    node.cell_y = tree_.zones[zone].cell_y;
    return node;
  }

  ZoneTree tree_;
  const SimplifyContext& context_;
  ProxyCache& cache_;
  BakeContext& bake_;
  std::vector<ZoneState> states_;
  std::atomic<std::uint64_t> work_ = 0;
};

}  // namespace

Result<ProxyTree> build_proxies(ProxyInput&& input, BakeContext& context) {
  context.begin(BakeStage::kSimplify, input.tree.zones.size());
  const std::vector<std::uint16_t> appearances = appearance_classes(input.materials);
  const CellGrid grid = input.tree.grid;
  const SimplifyContext simplify = {&grid,         input.materials,      appearances,  input.step_m,
                                    input.error_m, input.leaf_triangles, input.atlases};
  ProxyCache cache(input.cache, input.materials.size());
  return Builder(std::move(input.tree), simplify, cache, context).run();
}

}  // namespace zc
