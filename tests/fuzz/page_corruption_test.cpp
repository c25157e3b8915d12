// SPDX-License-Identifier: GPL-3.0-or-later
// A page with any random corruption is rejected, or traces without an access outside the page.
// ZONECAST_FUZZ_SEED and ZONECAST_FUZZ_TRIES choose other damage and more of it.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <glm/geometric.hpp>
#include <random>

#include "tests/fuzz/baked_pages.h"
#include "tests/fuzz/checked_tracer.h"
#include "tests/fuzz/page_audit.h"
#include "tests/fuzz/page_corruption.h"

namespace zc {
namespace {

const test::BakedPages& baked() {
  static const test::BakedPages pages = [] {
    Result<test::BakedPages> made = test::bake_pages(12);
    EXPECT_TRUE(made.ok()) << made.error().describe();
    // A page without split triangles is a sound page of the kind that has some, and is checked by other rules.
    if (made.ok()) {
      made->pages.push_back(made->pages.back());
      made->pages.back()[1] |= gpu::kPageSplitTriangles;
    }
    return made.ok() ? *std::move(made) : test::BakedPages{};
  }();
  return pages;
}

struct Counts {
  std::array<std::uint64_t, test::kDamageNames.size()> tried{}, accepted{};
  std::uint64_t all_accepted = 0;

  void add(test::Damage damage, bool ok) {
    ++tried[static_cast<std::size_t>(damage)];
    accepted[static_cast<std::size_t>(damage)] += ok ? 1 : 0;
    all_accepted += ok ? 1 : 0;
  }
  void print(std::uint64_t seed) const {
    std::uint64_t all = 0;
    for (const std::uint64_t n : tried) all += n;
    std::printf("seed %llu: %llu corruptions, %llu rejected, %llu accepted\n", static_cast<unsigned long long>(seed),
                static_cast<unsigned long long>(all), static_cast<unsigned long long>(all - all_accepted),
                static_cast<unsigned long long>(all_accepted));
    for (std::size_t i = 0; i < tried.size(); ++i)
      std::printf("  %-22s %5llu tried %5llu accepted\n", test::kDamageNames[i].data(),
                  static_cast<unsigned long long>(tried[i]), static_cast<unsigned long long>(accepted[i]));
  }
};

// What the pages are made of is part of what these tests promise.
TEST(CorruptPage, SourcesAreSoundAndOfEveryKind) {
  ASSERT_GE(baked().pages.size(), 8U);
  std::uint32_t most_clusters = 0;
  std::uint32_t least_clusters = UINT32_MAX;
  bool marked = false;
  for (const auto& page : baked().pages) {
    EXPECT_TRUE(verify_page(page, baked().material_count, "p").ok());
    const auto fault = test::PageAudit(page, 4096, baked().material_count).run();
    EXPECT_FALSE(fault.has_value()) << *fault;
    const gpu::PageHeader header = PageView(page).header();
    most_clusters = std::max(most_clusters, header.cluster_count);
    least_clusters = std::min(least_clusters, header.cluster_count);
    marked = marked || (header.flags & gpu::kPageSplitTriangles) != 0;
    std::printf("page of %zu words: %u nodes, %u triangles, %u clusters, depth %u\n", page.size(), header.node_count,
                header.triangle_count, header.cluster_count, header.depth);
  }
  EXPECT_GT(most_clusters, 1U);
  EXPECT_EQ(least_clusters, 1U);
  EXPECT_TRUE(marked);
}

TEST(CorruptPage, IsRejectedOrNothingInItLeadsOutOfIt) {
  ASSERT_FALSE(baked().pages.empty());
  test::PageCorruption corruption(baked().pages, test::fuzz_seed());
  Counts counts;
  for (std::uint64_t i = 0; i < test::fuzz_tries(); ++i) {
    const auto bad = corruption.next();
    const Status verified = verify_page(bad.words, baked().material_count, "p");
    counts.add(bad.damage, verified.ok());
    if (!verified.ok()) continue;
    // Anywhere in a pool, at its very end as well.
    for (const std::uint32_t base : {0U, 1U << 20U, static_cast<std::uint32_t>(0U - bad.words.size())}) {
      const auto fault = test::PageAudit(bad.words, base, baked().material_count).run();
      ASSERT_FALSE(fault.has_value()) << "try " << i << ": " << *fault;
    }
  }
  counts.print(test::fuzz_seed());
  EXPECT_GT(counts.all_accepted, test::fuzz_tries() / 50);
  EXPECT_LT(counts.all_accepted, test::fuzz_tries() / 2);
}

glm::vec3 metres(const std::array<double, 3>& lattice, const std::array<std::int32_t, 3>& origin, double step_m) {
  return {static_cast<float>((lattice[0] - origin[0]) * step_m), static_cast<float>((lattice[1] - origin[1]) * step_m),
          static_cast<float>((lattice[2] - origin[2]) * step_m)};
}

// A view of a sound page, and rays that intersect it: half of them in bundles, which packets are made of.
struct View {
  FrameCamera camera;
  std::vector<gpu::RayTask> rays;
};

View make_view(const std::vector<std::uint32_t>& page, double step_m, std::uint64_t seed) {
  const PageView appearance(page);
  std::array<double, 3> low, high;
  low.fill(INFINITY);
  high.fill(-INFINITY);
  std::vector<std::array<double, 3>> middles;
  for (std::uint32_t t = 0; t < appearance.header().triangle_count; ++t) {
    middles.push_back({});
    for (const auto& corner : appearance.triangle(t).corners) {
      for (std::size_t a = 0; a < 3; ++a) {
        low[a] = std::min<double>(low[a], corner[a]);
        high[a] = std::max<double>(high[a], corner[a]);
        middles.back()[a] += corner[a] / 3.0;
      }
    }
  }
  View view;
  view.camera.step_m = step_m;
  for (std::size_t a = 0; a < 3; ++a) view.camera.lattice[a] = static_cast<std::int32_t>((low[a] + high[a]) / 2);
  const glm::vec3 half = metres(high, view.camera.lattice, step_m);

  std::mt19937_64 random(seed);
  const auto unit = [&] { return static_cast<float>(static_cast<double>(random() >> 11) * 0x1p-53 * 2 - 1); };
  const auto somewhere = [&](const glm::vec3& size) {
    const float x = unit();
    const float y = unit();
    return glm::vec3(x, y, unit()) * size;
  };
  glm::vec3 from, to, side;
  for (std::uint32_t i = 0; i < test::CheckedTracer::kRays; ++i) {
    const bool bundled = i >= test::CheckedTracer::kRays / 2;
    if (!bundled || i % 32 == 0) {
      from = somewhere(half * 1.3F);
      to = metres(middles[random() % middles.size()], view.camera.lattice, step_m);
      side = somewhere(glm::vec3(0.3F));
    }
    const glm::vec3 shift = bundled ? side * (static_cast<float>(i % 32) / 8) : glm::vec3(0);
    glm::vec3 d = to - from;
    if (glm::length(d) < 1e-3F) d = {0, 0, -1};
    d = glm::normalize(d + shift * 0.02F);
    gpu::RayTask ray{};
    ray.origin_x = from.x + shift.x, ray.origin_y = from.y + shift.y, ray.origin_z = from.z + shift.z;
    ray.dir_x = d.x, ray.dir_y = d.y, ray.dir_z = d.z;
    ray.origin_normal = gpu::kNoSurface;
    view.rays.push_back(ray);
  }
  view.camera.eye = half * glm::vec3(-0.9F, -0.9F, 1.5F);
  view.camera.forward = glm::normalize(-view.camera.eye);
  view.camera.right = glm::normalize(glm::cross(view.camera.forward, glm::vec3(0, 0, 1)));
  view.camera.up = glm::cross(view.camera.right, view.camera.forward);
  return view;
}

// The neighbour lies in front, the page under test behind it, with gaps that belong to nobody.
class TracedCorruption : public testing::Test {
 protected:
  static constexpr std::uint32_t kGap = 64;

  void SetUp() override {
    ASSERT_GE(baked().pages.size(), 2U);
    std::size_t longest = 0;
    std::uint32_t most_nodes = 0;
    for (std::size_t i = 0; i < baked().pages.size(); ++i) {
      const auto& page = baked().pages[i];
      longest = std::max(longest, page.size());
      most_nodes = std::max(most_nodes, PageView(page).header().node_count);
      views_.push_back(make_view(page, baked().step_m, i));
    }
    // A traversal visits every node at most once, so that with so few it never reaches its bound of steps.
    ASSERT_LT(2 * most_nodes + 64, 2000U);
    page_word_ = static_cast<std::uint32_t>((2 * kGap + neighbour().size()) / 4 * 4);
    const Status opened = tracer_.open(page_word_ + longest + 4 * kGap, baked().material_count);
    ASSERT_TRUE(opened.ok()) << opened.error().describe();
  }

  [[nodiscard]] static const std::vector<std::uint32_t>& neighbour() { return baked().pages.front(); }

  void show(const std::vector<std::uint32_t>& page) {
    const std::array pages = {test::TracedOne{kGap, neighbour()}, test::TracedOne{page_word_, page}};
    const Status shown = tracer_.show(pages);
    ASSERT_TRUE(shown.ok()) << shown.error().describe();
  }

  test::CheckedTracer tracer_;
  std::vector<View> views_;  // by page
  std::uint32_t page_word_ = 0;
};

TEST_F(TracedCorruption, IsRejectedOrTracesWithoutLeavingThePage) {
  test::PageCorruption corruption(baked().pages, test::fuzz_seed());
  Counts counts;
  std::array<test::TraceSums, test::CheckedTracer::kKernels.size()> sums{};
  std::uint64_t frames = 0;
  std::uint64_t frame_hits = 0;
  const auto expect_clean = [&](const test::TraceSums& one, std::uint64_t at) {
    ASSERT_EQ(one.out_of_page, 0U) << "try " << at;
    ASSERT_EQ(one.lost, 0U) << "try " << at;
    ASSERT_EQ(one.unknown_places, 0U) << "try " << at;
  };
  for (std::uint64_t i = 0; i < test::fuzz_tries(); ++i) {
    const auto bad = corruption.next();
    const bool accepted = verify_page(bad.words, baked().material_count, "p").ok();
    counts.add(bad.damage, accepted);
    if (!accepted) continue;
    ASSERT_LE(PageView(bad.words).header().depth, test::CheckedTracer::kPageDepth);
    ASSERT_NO_FATAL_FAILURE(show(bad.words));
    const View& view = views_[bad.source];
    for (std::size_t kernel = 0; kernel < sums.size(); ++kernel) {
      const auto traced = tracer_.trace(kernel, view.camera, view.rays);
      ASSERT_TRUE(traced.ok()) << traced.error().describe();
      ASSERT_NO_FATAL_FAILURE(expect_clean(*traced, i));
      sums[kernel].rays += traced->rays;
      sums[kernel].hits += traced->hits;
      sums[kernel].alone += traced->alone;
    }
    if (counts.all_accepted % 16 == 0) {
      const auto drawn = tracer_.render(frames % sums.size(), view.camera);
      ASSERT_TRUE(drawn.ok()) << drawn.error().describe();
      ASSERT_NO_FATAL_FAILURE(expect_clean(*drawn, i));
      ++frames;
      frame_hits += drawn->hits;
    }
  }
  counts.print(test::fuzz_seed());
  for (std::size_t kernel = 0; kernel < sums.size(); ++kernel) {
    const TraceVariant& variant = test::CheckedTracer::kKernels[kernel];
    std::printf("  %s: %llu rays, %llu hits, %llu left to fallback rays\n", trace_variant_name(variant).c_str(),
                static_cast<unsigned long long>(sums[kernel].rays), static_cast<unsigned long long>(sums[kernel].hits),
                static_cast<unsigned long long>(sums[kernel].alone));
    EXPECT_GT(sums[kernel].hits, sums[kernel].rays / 4);
    EXPECT_EQ(sums[kernel].hits, sums[0].hits);
    EXPECT_LT(sums[kernel].alone, sums[kernel].rays);
    EXPECT_EQ(sums[kernel].alone > 0, variant.rays_per_lane > 0);
  }
  std::printf("  %llu frames, %llu hits in them; %s\n", static_cast<unsigned long long>(frames),
              static_cast<unsigned long long>(frame_hits), tracer_.device().name().c_str());
  EXPECT_GT(counts.all_accepted, test::fuzz_tries() / 50);
  EXPECT_LT(counts.all_accepted, test::fuzz_tries() / 2);
  EXPECT_GT(frame_hits, 0U);
  EXPECT_EQ(tracer_.device().validation_messages(), 0U);
}

// The check itself: pages that nobody verified lead astray, and every kernel reports it.
TEST_F(TracedCorruption, IsReportedWhereNobodyVerifiedThePage) {
  const std::vector<std::uint32_t>& good = baked().pages[1];
  const gpu::PageHeader header = PageView(good).header();
  struct Fault {
    const char* name;
    std::function<void(std::vector<std::uint32_t>&, std::size_t node, const gpu::PageNode&)> make;
  };
  const std::array faults = {Fault{"nothing", [](auto&, std::size_t, const auto&) {}},
                             Fault{"children behind the page",
                                   [&](auto& page, std::size_t node, const auto& n) {
                                     if (inner_mask(n) != 0 && node > gpu::kPageHeaderWords)
                                       page[node + 4] = header.total_words;
                                   }},
                             Fault{"children in the gap before the page",
                                   [&](auto& page, std::size_t node, const auto& n) {
                                     if (inner_mask(n) != 0 && node > gpu::kPageHeaderWords)
                                       page[node + 4] = 0U - static_cast<std::uint32_t>(node) - 20U;
                                   }},
                             Fault{"children beyond the pool",
                                   [](auto& page, std::size_t node, const auto& n) {
                                     if (inner_mask(n) != 0 && node > gpu::kPageHeaderWords)
                                       page[node + 4] = 0x40000000U;
                                   }},
                             Fault{"triangles behind the page",
                                   [&](auto& page, std::size_t node, const auto& n) {
                                     if (leaf_mask(n) != 0) page[node + 5] = header.total_words;
                                   }},
                             Fault{"clusters behind the page",
                                   [&](auto& page, std::size_t node, const auto& n) {
                                     if (leaf_mask(n) != 0) page[node + 7] = header.total_words;
                                   }},
                             Fault{"clusters that are not aligned",
                                   [](auto& page, std::size_t node, const auto& n) {
                                     if (leaf_mask(n) != 0) page[node + 7] += 1;
                                   }},
                             Fault{"vertices behind the page", [](auto& page, std::size_t node, const auto& n) {
                                     if (leaf_mask(n) != 0) page[node + n.cluster_offset + 3] |= 0x3FFFFU << 9;
                                   }}};
  for (const Fault& fault : faults) {
    std::vector<std::uint32_t> page = good;
    for (std::uint32_t i = 0; i < header.node_count; ++i)
      fault.make(page, PageView::node_word(i), PageView(good).node(i));
    const bool sound = page == good;
    EXPECT_EQ(verify_page(page, baked().material_count, "p").ok(), sound) << fault.name;
    EXPECT_EQ(test::PageAudit(page, page_word_, baked().material_count).run().has_value(), !sound) << fault.name;
    ASSERT_NO_FATAL_FAILURE(show(page));
    for (std::size_t kernel = 0; kernel < test::CheckedTracer::kKernels.size(); ++kernel) {
      const auto traced = tracer_.trace(kernel, views_[1].camera, views_[1].rays);
      ASSERT_TRUE(traced.ok()) << traced.error().describe();
      EXPECT_EQ(traced->out_of_page == 0, sound) << fault.name << ", kernel " << kernel;
      std::printf("%s, kernel %zu: %llu accesses out of page\n", fault.name, kernel,
                  static_cast<unsigned long long>(traced->out_of_page));
    }
  }
  EXPECT_EQ(tracer_.device().validation_messages(), 0U);
}

}  // namespace
}  // namespace zc
