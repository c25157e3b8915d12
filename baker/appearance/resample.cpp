// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/appearance/resample.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <limits>

namespace zc {
namespace {

// Sources seen more edge-on than this say nothing about the chart.
constexpr double kEdgeOnCosine = 0.1;
// How much nearer a source that faces the other way must be, in texels.
constexpr double kBehindTexels = 0.25;
// How far outside its triangle's outline a texel's centre still counts, in texels.
constexpr double kRim = 0.5;
// How far around its triangles a chart is painted, in texels.
constexpr double kGutter = 3;

struct Flat {
  double u = 0;
  double v = 0;
};

double cross(const Flat& a, const Flat& b, const Flat& c) {
  return (b.u - a.u) * (c.v - a.v) - (b.v - a.v) * (c.u - a.u);
}

// a + b * u + c * v.
struct Plane {
  double a = 0;
  double b = 0;
  double c = 0;

  [[nodiscard]] double at(const Flat& p) const { return a + b * p.u + c * p.v; }
};

// A triangle as the chart sees it, in texels.
struct Seen {
  std::array<Flat, 3> p;
  double area2 = 0;
  std::array<Plane, 3> edges;    // distance to each edge in texels, negative outside
  std::array<Plane, 3> corners;  // barycentric coordinates
  Plane depth;                   // zone steps

  Seen(const std::array<Flat, 3>& corner, const std::array<double, 3>& depths)
      : p(corner), area2(cross(corner[0], corner[1], corner[2])) {
    if (area2 == 0) return;
    for (std::size_t k = 0; k < 3; ++k) {
      const Flat& from = p[(k + 1) % 3];
      const Flat& to = p[(k + 2) % 3];
      const double length = std::hypot(to.u - from.u, to.v - from.v);
      const Plane doubled = {from.u * to.v - to.u * from.v, from.v - to.v, to.u - from.u};
      corners[k] = {doubled.a / area2, doubled.b / area2, doubled.c / area2};
      const double scale = std::copysign(1.0, area2) / length;  // an area has no edge without length
      edges[k] = {doubled.a * scale, doubled.b * scale, doubled.c * scale};
      depth.a += corners[k].a * depths[k];
      depth.b += corners[k].b * depths[k];
      depth.c += corners[k].c * depths[k];
    }
  }

  [[nodiscard]] double inside_by(const Flat& at) const {
    return std::min({edges[0].at(at), edges[1].at(at), edges[2].at(at)});
  }
};

class Painter {
 public:
  Painter(const ZoneMesh& mesh, const Chart& chart, const ChartRaster& raster)
      : mesh_(mesh), chart_(chart), raster_(raster), count_(std::size_t{raster.size[0]} * raster.size[1]) {}

  ChartTexels run(const ZoneFrame& frame, std::span<const SourceTriangle* const> sources, const TextureSource& textures,
                  std::span<const Material> materials, double reach) {
    mark_surface();
    color_.assign(count_, glm::vec3(0));
    distance_.assign(count_, std::numeric_limits<double>::max());
    for (const SourceTriangle* source : sources) paint(*source, frame, textures, materials, reach);
    return finish();
  }

 private:
  [[nodiscard]] Seen see(const std::array<glm::dvec3, 3>& p) const {
    std::array<Flat, 3> corner;
    std::array<double, 3> depth{};
    for (std::size_t k = 0; k < 3; ++k) {
      corner[k] = {p[k][chart_.u()] * raster_.texels_per_step - raster_.first[0],
                   p[k][chart_.v()] * raster_.texels_per_step - raster_.first[1]};
      depth[k] = p[k][static_cast<int>(chart_.axis)];
    }
    return {corner, depth};
  }

  // Calls visit(texel, centre) for the texels whose centres lie in the triangle or no further from it than `rim`.
  template <class Visit>
  void for_texels(const Seen& seen, double rim, const Visit& visit) const {
    // First and last centre of a row or column within [low, high].
    const auto centres = [](double low, double high, std::uint32_t size) {
      const double last = static_cast<double>(size) - 1;
      return std::array{static_cast<std::int64_t>(std::clamp(std::ceil(low - 0.5), 0.0, last + 1)),
                        static_cast<std::int64_t>(std::clamp(std::floor(high - 0.5), -1.0, last))};
    };
    const auto [bottom, top] = centres(std::min({seen.p[0].v, seen.p[1].v, seen.p[2].v}) - rim,
                                       std::max({seen.p[0].v, seen.p[1].v, seen.p[2].v}) + rim, raster_.size[1]);
    for (std::int64_t y = bottom; y <= top; ++y) {
      const double v = static_cast<double>(y) + 0.5;
      double low = std::min({seen.p[0].u, seen.p[1].u, seen.p[2].u}) - rim;
      double high = std::max({seen.p[0].u, seen.p[1].u, seen.p[2].u}) + rim;
      for (const Plane& edge : seen.edges) {
        const double rest = edge.a + edge.c * v + rim;  // + edge.b * u >= 0
        if (edge.b > 0) low = std::max(low, -rest / edge.b);
        if (edge.b < 0) high = std::min(high, -rest / edge.b);
        if (edge.b == 0 && rest < 0) high = low - 1;
      }
      if (!(low <= high)) continue;
      const auto [left, right] = centres(low, high, raster_.size[0]);
      for (std::int64_t x = left; x <= right; ++x)
        visit(static_cast<std::size_t>(y) * raster_.size[0] + static_cast<std::size_t>(x),
              Flat{static_cast<double>(x) + 0.5, v});
    }
  }

  // Depth of the chart's own surface at every texel that it reaches; beside it, of the nearest triangle's plane.
  void mark_surface() {
    depth_.assign(count_, 0);
    inside_.assign(count_, -std::numeric_limits<double>::max());
    for (const std::uint32_t t : chart_.triangles) {
      std::array<glm::dvec3, 3> p;
      for (std::size_t k = 0; k < 3; ++k) {
        const auto& q = mesh_.vertices[mesh_.triangles[t][k]];
        p[k] = {q[0], q[1], q[2]};
      }
      const Seen seen = see(p);
      if (seen.area2 == 0) continue;
      for_texels(seen, kGutter, [&](std::size_t i, const Flat& at) {
        const double inside = std::min(seen.inside_by(at), 0.0);
        if (inside <= inside_[i]) return;
        inside_[i] = inside;
        depth_[i] = seen.depth.at(at);
      });
    }
  }

  void paint(const SourceTriangle& source, const ZoneFrame& frame, const TextureSource& textures,
             std::span<const Material> materials, double reach) {
    std::array<glm::dvec3, 3> p;
    for (std::size_t k = 0; k < 3; ++k) p[k] = (source.p[k] - frame.origin) / frame.steps;
    const glm::dvec3 normal = glm::cross(p[1] - p[0], p[2] - p[0]);
    const double along = normal[static_cast<int>(chart_.axis)];
    if (!(std::abs(along) > kEdgeOnCosine * glm::length(normal))) return;
    const Seen seen = see(p);
    if (seen.area2 == 0) return;
    const double penalty = along * chart_.facing > 0 ? 0 : kBehindTexels / raster_.texels_per_step;
    const SurfaceTexture& texture = *materials[source.material].texture;
    const TextureImage& image = textures.image(texture.image);

    // Texels of the image in one of the chart's, along its u and v.
    const glm::vec2 e1 = source.uv[1] - source.uv[0];
    const glm::vec2 e2 = source.uv[2] - source.uv[0];
    const Flat d1 = {seen.p[1].u - seen.p[0].u, seen.p[1].v - seen.p[0].v};
    const Flat d2 = {seen.p[2].u - seen.p[0].u, seen.p[2].v - seen.p[0].v};
    const glm::vec2 size(image.levels[0].width, image.levels[0].height);
    const auto part = [&](double a, double b) { return static_cast<float>(a / b); };
    const glm::vec2 per_u = (e1 * part(d2.v, seen.area2) - e2 * part(d1.v, seen.area2)) * size;
    const glm::vec2 per_v = (e2 * part(d1.u, seen.area2) - e1 * part(d2.u, seen.area2)) * size;
    const float width = std::max(glm::length(per_u), glm::length(per_v));
    const float level = width > 1 ? std::log2(std::min(width, 1e6F)) : 0;  // no number: the finest

    for_texels(seen, kRim, [&](std::size_t i, const Flat& at) {
      if (inside_[i] < -kGutter) return;
      const double off = std::abs(seen.depth.at(at) - depth_[i]);
      // On the rim a neighbour that contains the texel wins.
      const double distance = off + penalty + std::max(-seen.inside_by(at), 0.0) / raster_.texels_per_step;
      if (off > reach || distance >= distance_[i]) return;
      distance_[i] = distance;
      glm::vec2 uv(0);
      for (std::size_t k = 0; k < 3; ++k) uv += source.uv[k] * static_cast<float>(seen.corners[k].at(at));
      const auto fine = static_cast<std::size_t>(level);
      const glm::vec3 low = image.sample(uv, fine, texture.wrap_u, texture.wrap_v);
      const glm::vec3 high = image.sample(uv, fine + 1, texture.wrap_u, texture.wrap_v);
      color_[i] = glm::clamp(texture.offset + texture.factor * glm::mix(low, high, level - std::floor(level)),
                             glm::vec3(0), glm::vec3(1));
    });
  }

  // Texels without a source take the colours around them, ring by ring.
  void spread() {
    const std::size_t width = raster_.size[0];
    const std::size_t height = raster_.size[1];
    std::vector<std::size_t> front;
    std::vector<bool> has(count_);
    for (std::size_t i = 0; i < count_; ++i) has[i] = distance_[i] != std::numeric_limits<double>::max();
    const auto neighbours = [&](std::size_t i, const auto& visit) {
      const std::size_t x = i % width;
      const std::size_t y = i / width;
      if (x > 0) visit(i - 1);
      if (x + 1 < width) visit(i + 1);
      if (y > 0) visit(i - width);
      if (y + 1 < height) visit(i + width);
    };
    std::vector<bool> queued(count_);
    const auto queue_around = [&](std::size_t i) {
      neighbours(i, [&](std::size_t n) {
        if (has[n] || queued[n]) return;
        queued[n] = true;
        front.push_back(n);
      });
    };
    for (std::size_t i = 0; i < count_; ++i)
      if (has[i]) queue_around(i);
    while (!front.empty()) {
      const std::vector<std::size_t> ring = std::move(front);
      front.clear();
      for (const std::size_t i : ring) {
        glm::vec3 sum(0);
        float count = 0;
        neighbours(i, [&](std::size_t n) {
          if (!has[n]) return;
          sum += color_[n];
          ++count;
        });
        color_[i] = sum / count;
      }
      for (const std::size_t i : ring) has[i] = true;
      for (const std::size_t i : ring) queue_around(i);
    }
  }

  ChartTexels finish() {
    ChartTexels out;
    out.painted = std::ranges::any_of(distance_, [](double d) { return d != std::numeric_limits<double>::max(); });
    if (!out.painted) return out;
    spread();
    glm::dvec3 sum(0);
    glm::dvec3 coded(0);
    glm::dvec3 squared(0);
    double count = 0;
    for (const double least : {0.0, -kRim, -std::numeric_limits<double>::max()}) {  // thin charts contain no centre
      for (std::size_t i = 0; i < count_; ++i) {
        if (inside_[i] < least) continue;
        sum += glm::dvec3(color_[i]);
        const glm::dvec3 c(linear_to_srgb8(color_[i].r), linear_to_srgb8(color_[i].g), linear_to_srgb8(color_[i].b));
        coded += c;
        squared += c * c;
        ++count;
      }
      if (count > 0) break;
    }
    out.mean = glm::vec3(sum / count);
    const glm::dvec3 variance = glm::max(squared / count - (coded / count) * (coded / count), glm::dvec3(0));
    out.deviation = static_cast<float>(std::sqrt(std::max({variance.x, variance.y, variance.z})));
    out.colors = std::move(color_);
    return out;
  }

  const ZoneMesh& mesh_;
  const Chart& chart_;
  const ChartRaster& raster_;
  std::size_t count_;
  std::vector<double> depth_;   // of the chart's surface
  std::vector<double> inside_;  // 0 on it, else minus the distance to it in texels
  std::vector<glm::vec3> color_;
  std::vector<double> distance_;  // to the source that painted the texel
};

}  // namespace

ChartTexels resample(const ZoneMesh& mesh, const Chart& chart, const ChartRaster& raster, const ZoneFrame& frame,
                     std::span<const SourceTriangle* const> sources, const TextureSource& textures,
                     std::span<const Material> materials, double reach) {
  return Painter(mesh, chart, raster).run(frame, sources, textures, materials, reach);
}

}  // namespace zc
