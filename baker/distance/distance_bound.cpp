// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/distance/distance_bound.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <limits>
#include <optional>
#include <vector>

#include "baker/distance/hausdorff_bound.h"

namespace zc {
namespace {

constexpr double kLoose = 1.02;               // over what samples found
constexpr double kLeast = 0.1;                // steps: what is nearer is as good as on the surface
constexpr double kMargin = 0.5;               // of what is enough
constexpr double kLeastPiece = 0.03;          // of what is enough
constexpr double kNear = 0.1;                 // of what is enough: no search for what is nearer still
constexpr double kGrowth = 1.1;               // from one round to the next
constexpr std::uint32_t kPieces = 2000;       // a round
constexpr std::uint32_t kMorePieces = 20000;  // of the round that confirms the promise
constexpr int kRounds = 12;
constexpr std::size_t kBlock = 64;  // faces that share the work they may take
constexpr std::uint64_t kBlockWork = 500'000;
constexpr std::uint64_t kLeastMoreWork = 8'000'000;  // of the blocks together that need more, whatever their number
constexpr std::uint64_t kMoreWorkPerFace = 4'000;

// The nearest of several surfaces.
class NearestOfAll {
 public:
  NearestOfAll(std::span<const DetailSurface> surfaces, double near, Work& work)
      : surfaces_(surfaces), near_(near), work_(work) {}

  const DistanceTriangle* operator()(const glm::dvec3& p, double& distance) const {
    const DistanceTriangle* found = nullptr;
    const std::size_t first = nearest_box(surfaces_, p);
    surfaces_[first].bvh->nearest(p, std::nullopt, near_, found, distance, &work_);
    for (std::size_t i = 0; i < surfaces_.size() && distance > near_; ++i)
      if (i != first && surfaces_[i].bvh->distance_to_bounds(p) < distance)
        surfaces_[i].bvh->nearest(p, std::nullopt, near_, found, distance, &work_);
    return found;
  }

 private:
  std::span<const DetailSurface> surfaces_;
  double near_;
  Work& work_;
};

// Ever wider bounds, until one holds.
double bound_triangle(const Corners& triangle, std::span<const DetailSurface> to, double known, double promise,
                      Work& work) {
  double least = std::numeric_limits<double>::infinity();
  double enough = std::max(kLoose * known, known + kLeast);
  for (int round = 0; round < kRounds; ++round) {
    const bool confirms = known <= promise && promise <= enough;
    if (confirms) enough = promise;
    const NearestOfAll nearest(to, kNear * enough, work);
    const HausdorffLimits limits = {
        enough, kMargin * enough, kLeastPiece * enough, confirms ? kMorePieces : kPieces, false, &work};
    const HausdorffBound found = hausdorff_bound(triangle, limits, nearest);
    least = std::min(least, found.bound);
    if (found.within || work.is_spent()) break;
    double reached = std::numeric_limits<double>::infinity();
    NearestOfAll(to, 0, work)(found.outside, reached);
    known = std::max(known, reached);
    enough = std::max(kGrowth * enough, kLoose * reached);
    if (confirms) promise = 0;
  }
  return least;
}

}  // namespace

DistanceBound bound_distance(const LatticeMesh& from, std::span<const DetailSurface> to, double known, double promise) {
  const std::size_t count = from.faces.size();
  std::vector<DistanceBound> blocks((count + kBlock - 1) / kBlock);
  const auto bound_block = [&](std::size_t b, std::uint64_t limit) {
    Work work{limit};
    double distance = 0;
    for (std::size_t i = b * kBlock; i < std::min(count, (b + 1) * kBlock); ++i)
      distance = std::max(distance, bound_triangle(corners_of(from, from.faces[i]), to, known, promise, work));
    blocks[b] = {distance, blocks[b].work + work.done, work.is_spent()};
  };
  tbb::parallel_for(std::size_t{0}, blocks.size(), [&](std::size_t b) { bound_block(b, kBlockWork); });
  std::vector<std::size_t> hard;
  for (std::size_t b = 0; b < blocks.size(); ++b)
    if (blocks[b].is_loose) hard.push_back(b);
  const std::uint64_t more = (kLeastMoreWork + kMoreWorkPerFace * count) / std::max<std::size_t>(hard.size(), 1);
  if (more > kBlockWork)
    tbb::parallel_for(std::size_t{0}, hard.size(), [&](std::size_t i) { bound_block(hard[i], more); });
  DistanceBound bound = {known, 0, false};
  for (const DistanceBound& block : blocks) {
    bound.distance = std::max(bound.distance, block.distance);
    bound.work += block.work;
    bound.is_loose = bound.is_loose || block.is_loose;
  }
  return bound;
}

}  // namespace zc
