// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/distance_bound.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <limits>
#include <vector>

#include "baker/triangle_cover.h"

namespace zc {
namespace {

constexpr double kLoose = 1.02;               // over what samples found
constexpr double kLeast = 0.1;                // steps: what is nearer is as good as on the surface
constexpr double kMargin = 0.5;               // of what is enough
constexpr double kLeastPiece = 0.03;          // of what is enough
constexpr double kNear = 0.1;                 // of what is enough: no need to look for what is nearer still
constexpr double kGrowth = 1.1;               // from one round to the next
constexpr std::uint32_t kPieces = 2000;       // a round
constexpr std::uint32_t kMorePieces = 20000;  // of the round that confirms the promise
constexpr int kRounds = 12;

// The nearest of several surfaces, the one with the nearest box first: it usually settles all others.
class NearestOfAll {
 public:
  NearestOfAll(std::span<const DetailSurface> surfaces, double near) : surfaces_(surfaces), near_(near) {}

  const DistanceTriangle* operator()(const glm::dvec3& p, double& distance) const {
    const DistanceTriangle* found = nullptr;
    std::size_t first = 0;
    if (surfaces_.size() > 1) {
      double first_distance = std::numeric_limits<double>::infinity();
      for (std::size_t i = 0; i < surfaces_.size(); ++i) {
        const double to_box = surfaces_[i].bvh->distance_to_bounds(p);
        if (to_box >= first_distance) continue;
        first = i;
        first_distance = to_box;
      }
    }
    surfaces_[first].bvh->nearest(p, kEveryLook, near_, found, distance);
    for (std::size_t i = 0; i < surfaces_.size() && distance > near_; ++i)
      if (i != first && surfaces_[i].bvh->distance_to_bounds(p) < distance)
        surfaces_[i].bvh->nearest(p, kEveryLook, near_, found, distance);
    return found;
  }

 private:
  std::span<const DetailSurface> surfaces_;
  double near_;
};

// Ever wider bounds, until one holds.
double bound_triangle(const Corners& triangle, std::span<const DetailSurface> to, double known, double promise) {
  double least = std::numeric_limits<double>::infinity();
  double enough = std::max(kLoose * known, known + kLeast);
  for (int round = 0; round < kRounds; ++round) {
    const bool confirms = known <= promise && promise <= enough;
    if (confirms) enough = promise;
    const NearestOfAll nearest(to, kNear * enough);
    const CoverLimits limits = {enough, kMargin * enough, kLeastPiece * enough, confirms ? kMorePieces : kPieces,
                                false};
    const Cover found = cover(triangle, limits, nearest);
    least = std::min(least, found.most);
    if (found.within) break;
    double reached = std::numeric_limits<double>::infinity();
    NearestOfAll(to, 0)(found.outside, reached);
    known = std::max(known, reached);
    enough = std::max(kGrowth * enough, kLoose * reached);
    if (confirms) promise = 0;
  }
  return least;
}

}  // namespace

double bound_distance(const LatticeMesh& from, std::span<const DetailSurface> to, double known, double promise) {
  std::vector<double> bounds(from.faces.size());
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, bounds.size(), 64), [&](const auto& range) {
    for (std::size_t i = range.begin(); i != range.end(); ++i)
      bounds[i] = bound_triangle(corners_of(from, from.faces[i]), to, known, promise);
  });
  double bound = known;
  for (const double b : bounds) bound = std::max(bound, b);
  return bound;
}

}  // namespace zc
