// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/import/images/alpha_mask.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace zc {
namespace {

constexpr std::uint32_t kMaxSide = 512;
constexpr std::uint32_t kLeastSide = 4;
// Cells that are looked at for all triangles together, before a coarser level is taken.
constexpr double kMaxCells = 1 << 24;
// Smaller pieces than this, in texels², are left out: they are what rounding makes of a shared edge.
constexpr double kLeastArea = 1e-6;

using Point = glm::dvec2;
using Polygon = std::vector<Point>;

double twice_area(const Point& a, const Point& b, const Point& c) {
  return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

std::uint32_t wrapped(std::int64_t i, std::int64_t size, TextureWrap wrap) {
  if (wrap == TextureWrap::kClamp) return static_cast<std::uint32_t>(std::clamp<std::int64_t>(i, 0, size - 1));
  const std::int64_t period = wrap == TextureWrap::kMirror ? 2 * size : size;
  std::int64_t at = i % period;
  if (at < 0) at += period;
  return static_cast<std::uint32_t>(at < size ? at : period - 1 - at);
}

// A triangle in texels; points of it as shares of its corners.
class Placed {
 public:
  Placed(const AlphaMask::Triangle& triangle, std::uint32_t width, std::uint32_t height) {
    for (std::size_t c = 0; c < 3; ++c)
      corners_[c] = {triangle.uv[c].x * static_cast<double>(width) - 0.5,
                     triangle.uv[c].y * static_cast<double>(height) - 0.5};
    area_ = twice_area(corners_[0], corners_[1], corners_[2]);
    low = high = corners_[0];
    for (const Point& corner : corners_) {
      low = {std::min(low.x, corner.x), std::min(low.y, corner.y)};
      high = {std::max(high.x, corner.x), std::max(high.y, corner.y)};
    }
  }
  [[nodiscard]] bool is_usable() const {
    constexpr double kReach = 1e9;  // cells are counted in 64 bits
    return std::abs(area_) > kLeastArea && std::isfinite(area_) && low.x > -kReach && low.y > -kReach &&
           high.x < kReach && high.y < kReach;
  }
  [[nodiscard]] double cells() const { return (high.x - low.x + 2) * (high.y - low.y + 2); }

  // The part of a convex polygon within the triangle, as a fan.
  void clip(Polygon polygon, std::uint32_t of, AlphaMask::Cut& out) const {
    const double side = area_ > 0 ? 1 : -1;
    for (std::size_t e = 0; e < 3 && !polygon.empty(); ++e) {
      const Point& a = corners_[e];
      const Point& b = corners_[(e + 1) % 3];
      Polygon kept;
      for (std::size_t i = 0; i < polygon.size(); ++i) {
        const Point& p = polygon[i];
        const Point& q = polygon[(i + 1) % polygon.size()];
        const double at_p = side * twice_area(a, b, p);
        const double at_q = side * twice_area(a, b, q);
        if (at_p >= 0) kept.push_back(p);
        if ((at_p >= 0) != (at_q >= 0)) kept.push_back(p + (q - p) * (at_p / (at_p - at_q)));
      }
      polygon = std::move(kept);
    }
    for (std::size_t i = 1; i + 1 < polygon.size(); ++i) {
      if (std::abs(twice_area(polygon[0], polygon[i], polygon[i + 1])) < kLeastArea) continue;
      AlphaMask::Piece piece = {shares(polygon[0]), shares(polygon[i]), shares(polygon[i + 1])};
      // The mask's polygons turn one way; the piece turns as its triangle does.
      if (area_ < 0) std::swap(piece[1], piece[2]);
      out.pieces.push_back(piece);
      out.of.push_back(of);
    }
  }

  Point low{}, high{};

 private:
  [[nodiscard]] glm::vec3 shares(const Point& p) const {
    const double b = twice_area(corners_[0], p, corners_[2]) / area_;
    const double c = twice_area(corners_[0], corners_[1], p) / area_;
    return {static_cast<float>(1 - b - c), static_cast<float>(b), static_cast<float>(c)};
  }

  std::array<Point, 3> corners_{};
  double area_ = 0;
};

// The kept part of a triangle of the grid, whose corners have these values less the cutoff; turns as the triangle does.
Polygon kept_part(const std::array<Point, 3>& corners, const std::array<double, 3>& values) {
  Polygon polygon;
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t j = (i + 1) % 3;
    if (values[i] >= 0) polygon.push_back(corners[i]);
    if ((values[i] >= 0) != (values[j] >= 0))
      polygon.push_back(corners[i] + (corners[j] - corners[i]) * (values[i] / (values[i] - values[j])));
  }
  return polygon;
}

Polygon rectangle(double x0, double y0, double x1, double y1) { return {{x0, y0}, {x1, y0}, {x1, y1}, {x0, y1}}; }

}  // namespace

AlphaMask::AlphaMask(std::span<const std::uint8_t> pixels, std::uint32_t width, std::uint32_t height,
                     std::uint32_t channels) {
  Level level{width, height, {}};
  level.alpha.reserve(std::size_t{width} * height);
  for (std::size_t at = channels - 1; at < pixels.size(); at += channels) level.alpha.push_back(pixels[at]);
  const auto halved = [](const Level& from) {
    Level to{(from.width + 1) / 2, (from.height + 1) / 2, {}};
    for (std::uint32_t y = 0; y < to.height; ++y)
      for (std::uint32_t x = 0; x < to.width; ++x) {
        std::uint32_t sum = 0;
        for (const std::uint32_t row : {2 * y, std::min(2 * y + 1, from.height - 1)})
          for (const std::uint32_t column : {2 * x, std::min(2 * x + 1, from.width - 1)})
            sum += from.alpha[std::size_t{row} * from.width + column];
        to.alpha.push_back(static_cast<std::uint8_t>((sum + 2) / 4));
      }
    return to;
  };
  while (std::max(level.width, level.height) > kMaxSide) level = halved(level);
  levels_.push_back(std::move(level));
  while (std::min(levels_.back().width, levels_.back().height) > kLeastSide) levels_.push_back(halved(levels_.back()));
}

double AlphaMask::share_at_least(float cutoff) const {
  const auto& alpha = levels_.front().alpha;
  const auto passing =
      std::ranges::count_if(alpha, [&](std::uint8_t a) { return static_cast<float>(a) >= cutoff * 255; });
  return static_cast<double>(passing) / static_cast<double>(alpha.size());
}

// Of the level's area, as it is cut: between the texels, not beyond the outermost.
double AlphaMask::kept_share(std::size_t l, double limit) const {
  const Level& level = levels_[l];
  double area = 0;
  for (std::uint32_t y = 0; y + 1 < level.height; ++y)
    for (std::uint32_t x = 0; x + 1 < level.width; ++x) {
      const auto at = [&](std::uint32_t i, std::uint32_t j) {
        return static_cast<double>(level.alpha[std::size_t{j} * level.width + i]) - limit;
      };
      const std::array<double, 4> values = {at(x, y), at(x + 1, y), at(x + 1, y + 1), at(x, y + 1)};
      const auto kept = std::ranges::count_if(values, [](double value) { return value >= 0; });
      if (kept == 4) ++area;
      if (kept == 4 || kept == 0) continue;
      for (const Polygon& part : {kept_part({Point{0, 0}, {1, 0}, {1, 1}}, {values[0], values[1], values[2]}),
                                  kept_part({Point{0, 0}, {1, 1}, {0, 1}}, {values[0], values[2], values[3]})})
        for (std::size_t i = 1; i + 1 < part.size(); ++i) area += twice_area(part[0], part[i], part[i + 1]) / 2;
    }
  return area / (static_cast<double>(level.width - 1) * (level.height - 1));
}

// Of the finest level the one that is asked for; of the others what leaves as much, by bisection. No texel lies on it.
double AlphaMask::limit_of(std::size_t level, float cutoff) const {
  const double finest = std::max(1.0, std::ceil(cutoff * 255.0)) - 0.5;
  if (level == 0) return finest;
  const double wanted = kept_share(0, finest);
  double low = 0.25;
  double high = 254.75;
  constexpr int kSteps = 12;
  for (int i = 0; i < kSteps; ++i) {
    const double middle = (low + high) / 2;
    (kept_share(level, middle) > wanted ? low : high) = middle;
  }
  const double limit = (low + high) / 2;
  return limit == std::floor(limit) ? limit + 1.0 / 1024 : limit;
}

bool AlphaMask::cut_at(std::size_t l, std::span<const Triangle> triangles, TextureWrap wrap_u, TextureWrap wrap_v,
                       float cutoff, std::size_t most, Cut& out) const {
  const Level& level = levels_[l];
  const double limit = limit_of(l, cutoff);
  double cells = 0;
  for (const Triangle& triangle : triangles) cells += Placed(triangle, level.width, level.height).cells();
  const bool is_coarsest = l + 1 == levels_.size();
  if (!(cells < kMaxCells) && !is_coarsest) return false;
  // Kept from side to side, and from `top` on to where it is closed.
  struct Run {
    double begin, end, top;
  };
  std::vector<Run> open;
  std::vector<Run> row;
  for (std::uint32_t t = 0; t < triangles.size(); ++t) {
    const Placed placed(triangles[t], level.width, level.height);
    if (!placed.is_usable() || placed.cells() > kMaxCells) {  // seen edge on, or repeated beyond reason: kept
      out.pieces.push_back({glm::vec3(1, 0, 0), glm::vec3(0, 1, 0), glm::vec3(0, 0, 1)});
      out.of.push_back(t);
      continue;
    }
    const auto at = [&](std::int64_t x, std::int64_t y) {
      return static_cast<double>(level.alpha[std::size_t{wrapped(y, level.height, wrap_v)} * level.width +
                                             wrapped(x, level.width, wrap_u)]) -
             limit;
    };
    const auto left = static_cast<std::int64_t>(std::floor(placed.low.x));
    const auto right = static_cast<std::int64_t>(std::floor(placed.high.x));
    const auto top = static_cast<std::int64_t>(std::floor(placed.low.y));
    const auto bottom = static_cast<std::int64_t>(std::floor(placed.high.y));
    const auto close = [&](const Run& run, double y) {
      placed.clip(rectangle(run.begin, run.top, run.end, y), t, out);
    };
    const auto add = [](std::vector<Run>& runs, const Run& run) {
      if (!runs.empty() && runs.back().end == run.begin && runs.back().top == run.top)
        runs.back().end = run.end;
      else
        runs.push_back(run);
    };
    open.clear();
    for (std::int64_t y = top; y <= bottom; ++y) {
      const auto py = static_cast<double>(y);
      row.clear();
      double strip_begin = 0;  // of cells that a level edge crosses alike
      std::array<double, 2> strip{};
      double strip_end = -1;
      const auto close_strip = [&] {
        if (strip_end < strip_begin) return;
        const double edge = py + strip[0] / (strip[0] - strip[1]);
        close({strip_begin, strip_end, strip[0] >= 0 ? py : edge}, strip[0] >= 0 ? edge : py + 1);
        strip_end = strip_begin - 1;
      };
      for (std::int64_t x = left; x <= right; ++x) {
        const auto px = static_cast<double>(x);
        const std::array<double, 4> values = {at(x, y), at(x + 1, y), at(x + 1, y + 1), at(x, y + 1)};
        const auto kept = std::ranges::count_if(values, [](double value) { return value >= 0; });
        if (kept == 0) continue;
        if (values[0] == values[3] && values[1] == values[2]) {  // no edge, or one straight down
          const double edge = kept == 4 ? px : px + values[0] / (values[0] - values[1]);
          add(row, {values[0] >= 0 ? px : edge, values[1] >= 0 ? px + 1 : edge, py});
        } else if (kept == 4) {
          add(row, {px, px + 1, py});
        } else if (values[0] == values[1] && values[2] == values[3]) {  // a level edge
          if (strip_end != px || strip[0] != values[0] || strip[1] != values[3]) {
            close_strip();
            strip_begin = px;
            strip = {values[0], values[3]};
          }
          strip_end = px + 1;
        } else {
          const std::array<Point, 4> corners = {Point{px, py}, {px + 1, py}, {px + 1, py + 1}, {px, py + 1}};
          for (const std::array<std::size_t, 3>& half :
               {std::array<std::size_t, 3>{0, 1, 2}, std::array<std::size_t, 3>{0, 2, 3}})
            placed.clip(kept_part({corners[half[0]], corners[half[1]], corners[half[2]]},
                                  {values[half[0]], values[half[1]], values[half[2]]}),
                        t, out);
        }
      }
      close_strip();
      // Runs that are as wide as those above them grow downwards.
      for (const Run& above : open) {
        const auto same =
            std::ranges::find_if(row, [&](const Run& run) { return run.begin == above.begin && run.end == above.end; });
        if (same == row.end())
          close(above, py);
        else
          same->top = above.top;
      }
      std::swap(open, row);
      if (out.pieces.size() > most && !is_coarsest) return false;
    }
    for (const Run& run : open) close(run, static_cast<double>(bottom + 1));
  }
  return out.pieces.size() <= most || is_coarsest;
}

AlphaMask::Cut AlphaMask::cut(std::span<const Triangle> triangles, TextureWrap wrap_u, TextureWrap wrap_v, float cutoff,
                              std::size_t most) const {
  Cut out;
  out.is_whole = share_at_least(cutoff) == 1;
  if (out.is_whole) return out;
  for (std::size_t level = 0; level < levels_.size(); ++level) {
    out.pieces.clear();
    out.of.clear();
    if (cut_at(level, triangles, wrap_u, wrap_v, cutoff, most, out)) break;
  }
  return out;
}

}  // namespace zc
