// SPDX-License-Identifier: Apache-2.0
#include "replay/paths/world_tour.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>
#include <limits>
#include <numbers>
#include <vector>

#include "replay/host/zone_draws.h"
#include "replay/paths/frame_camera.h"
#include "streamer/paging/page_loader.h"
#include "streamer/world_format/page_view.h"

namespace zc {
namespace {

Bounds bounds_of(const IndexView& index, const std::array<std::int32_t, 3>& low,
                 const std::array<std::int32_t, 3>& high) {
  Bounds out{};
  for (int axis = 0; axis < 3; ++axis) {
    const auto i = static_cast<std::size_t>(axis);
    const auto anchor = static_cast<double>(index.header.anchor[i]);
    out.min[axis] = (anchor + low[i]) * index.step_m();
    out.max[axis] = (anchor + high[i]) * index.step_m();
  }
  return out;
}

// The finest zones: where there is something. `see`: whether to go on.
template <class See>
void each_leaf(const IndexView& index, const See& see) {
  for (std::uint32_t n = 0; n < index.nodes.size(); ++n) {
    const NodeRecord node = index.nodes[n];
    const bool leaf = node.child_count == 0 || index.nodes[node.first_child].is_detail();
    if (leaf && !node.is_detail() && !see(node, bounds_of(index, node.bounds_min, node.bounds_max))) return;
  }
}

double distance_on_map(const glm::dvec3& a, const glm::dvec3& b) { return std::hypot(a.x - b.x, a.y - b.y); }

double nth(std::vector<double>& values, std::size_t n) {
  std::ranges::nth_element(values, values.begin() + static_cast<std::ptrdiff_t>(n));
  return values[n];
}

// Of the root's page; a thousand of them where there are more.
Result<std::vector<glm::dvec3>> triangle_centres(Source& source, const IndexView& index) {
  constexpr std::size_t kLimit = 1000;
  ZC_ASSIGN(const std::vector<std::uint32_t> page, load_page(source, index, 0));
  const PageView view(page);
  const std::size_t count = view.header().triangle_count;
  std::vector<glm::dvec3> centres;
  for (std::size_t i = 0; i < std::min(count, kLimit); ++i) {
    const auto corners = view.triangle(static_cast<std::uint32_t>(i * count / std::min(count, kLimit))).corners;
    glm::dvec3 sum{};
    for (int axis = 0; axis < 3; ++axis)
      for (const auto& corner : corners)
        sum[axis] += static_cast<double>(index.header.anchor[static_cast<std::size_t>(axis)] +
                                         corner[static_cast<std::size_t>(axis)]);
    centres.push_back(sum * (index.step_m() / 3));
  }
  return centres;
}

// The point that has a twentieth of all the nearest around it.
glm::dvec3 densest(const std::vector<glm::dvec3>& points) {
  glm::dvec3 best{};
  double least = std::numeric_limits<double>::infinity();
  std::vector<double> away(points.size());
  for (const glm::dvec3& p : points) {
    std::ranges::transform(points, away.begin(), [&](const glm::dvec3& q) { return distance_on_map(p, q); });
    const double reach = nth(away, points.size() / 20);
    if (reach < least) {
      least = reach;
      best = p;
    }
  }
  return best;
}

}  // namespace

Bounds world_bounds(const IndexView& index) {
  return bounds_of(index, index.header.bounds_min, index.header.bounds_max);
}

std::string describe_bounds(const IndexView& index) {
  const Bounds b = world_bounds(index);
  std::array<char, 256> text{};
  std::snprintf(text.data(), text.size(), "x %.1f to %.1f, y %.1f to %.1f, z %.1f to %.1f m", b.min.x, b.max.x, b.min.y,
                b.max.y, b.min.z, b.max.z);
  return text.data();
}

Result<CameraPath> tour_of(Source& source, const IndexView& index) {
  ZC_ASSIGN(const std::vector<glm::dvec3> points, triangle_centres(source, index));
  const glm::dvec3 centre = densest(points);
  std::vector<double> away;
  away.reserve(points.size());
  for (const glm::dvec3& p : points) away.push_back(distance_on_map(p, centre));
  const double radius = std::max(5.0, 1.5 * nth(away, away.size() / 2));  // a lone shed does not count
  const double farthest = std::min(1.5 * radius, 1500.0);                 // not so far that haze is all there is
  const double nearest = std::min(std::clamp(0.1 * radius, 25.0, 80.0), 0.5 * farthest);
  constexpr int kSamples = 600;
  constexpr double kPerSecond = 30;
  constexpr double kAboveRoofs_m = 10;
  CameraPath path;
  for (int i = 0; i < kSamples; ++i) {
    const double share = static_cast<double>(i) / (kSamples - 1);
    const double angle = 2 * std::numbers::pi * share - std::numbers::pi / 2;
    CameraSample sample;
    sample.time_s = i / kPerSecond;
    sample.target = centre;
    sample.eye =
        centre + farthest * std::pow(nearest / farthest, share) * glm::dvec3(std::cos(angle), std::sin(angle), 0.45);
    path.push_back(std::move(sample));
  }
  each_leaf(index, [&](const NodeRecord&, const Bounds& b) {
    for (CameraSample& sample : path) {
      const bool below =
          sample.eye.x > b.min.x && sample.eye.x < b.max.x && sample.eye.y > b.min.y && sample.eye.y < b.max.y;
      if (below) sample.eye.z = std::max(sample.eye.z, b.max.z + kAboveRoofs_m);
    }
    return true;
  });
  return path;
}

Result<bool> looks_at_world(const IndexView& index, const CameraSample& sample, double aspect) {
  constexpr double kLeastShareOfView = 0.02;
  ZC_ASSIGN(const FrameCamera camera, make_camera(index, sample));
  const Bounds world = world_bounds(index);
  const double away = glm::length(glm::max(glm::max(world.min - sample.eye, sample.eye - world.max), 0.0));
  if (glm::length(world.max - world.min) < kLeastShareOfView * glm::radians(sample.fov_y_deg) * away) return false;
  bool seen = false;
  each_leaf(index, [&](const NodeRecord& node, const Bounds&) {
    seen = !outside_view(camera, aspect, node);
    return !seen;
  });
  return seen;
}

Error nothing_seen(const IndexView& index, const CameraSample& first) {
  std::array<char, 128> eye{};
  std::snprintf(eye.data(), eye.size(), "%.1f, %.1f, %.1f", first.eye.x, first.eye.y, first.eye.z);
  return {ErrorCode::kArgument, "no camera of the path looks at the world: the first is at " + std::string(eye.data()) +
                                    ", the world at " + describe_bounds(index)};
}

}  // namespace zc
