// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/distance/measure.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <limits>
#include <numbers>

#include "baker/distance/distance_bound.h"

namespace zc {
namespace {

// Area samples of one side: so many per triangle, within limits.
constexpr std::size_t kSamplesPerTriangle = 6;
constexpr std::size_t kSamplesMin = 2000;
constexpr std::size_t kSamplesMax = 20000;
constexpr std::size_t kVerticesMax = 20000;
constexpr double kTieSteps = 1.0;
constexpr std::size_t kBlock = 512;  // samples that share the work they may take
// Twice what the hardest take of the cities that we know. Appearances have their own, so that one that is nowhere near
// leaves no distance loose.
constexpr std::uint64_t kBlockWork = 1'000'000;
constexpr std::uint64_t kBlockAppearanceWork = 400'000;

struct Sample {
  glm::dvec3 point;
  glm::dvec3 normal;
  std::uint16_t material = 0;
  bool is_vertex = false;  // counts for the largest distance only
};

std::size_t sample_count(std::size_t faces) {
  return std::clamp(kSamplesPerTriangle * faces, kSamplesMin, kSamplesMax);
}

// Stratified over the running area; within a triangle the R2 sequence (Roberts 2018) keeps samples apart.
void add_area_samples(const LatticeMesh& mesh, double area, std::size_t count, std::vector<Sample>& out) {
  if (mesh.faces.empty() || count == 0) return;
  double running = 0;
  std::size_t next = 0;
  for (const auto& face : mesh.faces) {
    running += face_area(mesh, face);
    const glm::dvec3 a = to_dvec(mesh.vertices[face.v[0]]);
    const glm::dvec3 ab = to_dvec(mesh.vertices[face.v[1]]) - a;
    const glm::dvec3 ac = to_dvec(mesh.vertices[face.v[2]]) - a;
    const glm::dvec3 normal = glm::normalize(glm::cross(ab, ac));
    while (next < count && (static_cast<double>(next) + 0.5) / static_cast<double>(count) * area <= running) {
      const auto n = static_cast<double>(next + 1);
      double u = 0.5 + n * 0.7548776662466927;
      double v = 0.5 + n * 0.5698402909980532;
      u -= std::floor(u);
      v -= std::floor(v);
      if (u + v > 1) {
        u = 1 - u;
        v = 1 - v;
      }
      out.push_back({a + ab * u + ac * v, normal, face.material, false});
      ++next;
    }
  }
}

void add_vertex_samples(const LatticeMesh& mesh, std::size_t limit, std::vector<Sample>& out) {
  if (mesh.vertices.empty()) return;
  const std::size_t stride = (mesh.vertices.size() + limit - 1) / limit;
  for (std::size_t i = 0; i < mesh.vertices.size(); i += stride)
    out.push_back({to_dvec(mesh.vertices[i]), glm::dvec3(0), 0, true});
}

ClosestHit closest_of(std::span<const DetailSurface> surfaces, const Sample& sample, Work& work) {
  ClosestHit best;
  best.distance = std::numeric_limits<double>::infinity();
  const std::size_t first = nearest_box(surfaces, sample.point);
  surfaces[first].bvh->closest(sample.point, sample.normal, kTieSteps, best, &work);
  for (std::size_t i = 0; i < surfaces.size(); ++i)
    if (i != first && surfaces[i].bvh->distance_to_bounds(sample.point) <= best.distance + kTieSteps)
      surfaces[i].bvh->closest(sample.point, sample.normal, kTieSteps, best, &work);
  return best;
}

// Distance from p to the nearest surface of an appearance, or to any within `enough`, or `limit`.
double appearance_distance(std::span<const DetailSurface> surfaces, const glm::dvec3& p, std::uint16_t appearance,
                           double limit, double enough, Work& work) {
  const std::size_t first = nearest_box(surfaces, p);
  limit = surfaces[first].bvh->closest_of_appearance(p, appearance, limit, enough, &work);
  for (std::size_t i = 0; i < surfaces.size() && limit > enough; ++i)
    if (i != first && surfaces[i].bvh->may_have(appearance) && surfaces[i].bvh->distance_to_bounds(p) < limit)
      limit = surfaces[i].bvh->closest_of_appearance(p, appearance, limit, enough, &work);
  return limit;
}

struct Sums {
  double max = 0;
  double appearance = 0;
  double distance = 0;
  double color = 0;
  double worst_alignment = 1;
  std::size_t count = 0;
  std::uint64_t work = 0;
  bool is_loose = false;
};

// `own`: the side that the samples lie on; `surfaces`: the other side.
void compare(const std::vector<Sample>& samples, std::span<const DetailSurface> own,
             std::span<const DetailSurface> surfaces, std::span<const Material> materials,
             std::span<const std::uint16_t> appearances, Sums& sums) {
  std::vector<ClosestHit> hits(samples.size());
  std::vector<double> appearance_m(samples.size(), 0.0);
  struct BlockWork {
    std::uint64_t done = 0;
    bool is_spent = false;
  };
  std::vector<BlockWork> blocks((samples.size() + kBlock - 1) / kBlock);
  tbb::parallel_for(std::size_t{0}, blocks.size(), [&](std::size_t block) {
    Work work{kBlockWork}, appearance_work{kBlockAppearanceWork};
    double largest = 0;  // of this block: a sample that cannot exceed it needs no exact distance
    for (std::size_t i = block * kBlock; i < std::min(samples.size(), (block + 1) * kBlock); ++i) {
      hits[i] = closest_of(surfaces, samples[i], work);
      const std::uint16_t appearance = appearances[samples[i].material];
      const std::uint16_t seen = appearances[hits[i].material];
      if (samples[i].is_vertex || appearance == seen) continue;
      const double here = appearance_distance(own, samples[i].point, seen, std::numeric_limits<double>::infinity(),
                                              largest, appearance_work);
      if (here <= largest) continue;
      appearance_m[i] = appearance_distance(surfaces, samples[i].point, appearance, here, largest, appearance_work);
      if (!std::isfinite(appearance_m[i])) appearance_m[i] = hits[i].distance;
      largest = std::max(largest, appearance_m[i]);
    }
    blocks[block] = {work.done + appearance_work.done, work.is_spent() || appearance_work.is_spent()};
  });
  for (const BlockWork& block : blocks) {
    sums.work += block.done;
    sums.is_loose = sums.is_loose || block.is_spent;
  }
  // Summed in order: the same result at any thread count.
  for (std::size_t i = 0; i < samples.size(); ++i) {
    sums.max = std::max(sums.max, hits[i].distance);
    sums.appearance = std::max(sums.appearance, appearance_m[i]);
    if (samples[i].is_vertex) continue;
    ++sums.count;
    sums.distance += hits[i].distance;
    sums.worst_alignment = std::min(sums.worst_alignment, hits[i].alignment);
    const glm::vec3 d = glm::abs(materials[samples[i].material].base_color - materials[hits[i].material].base_color);
    sums.color += static_cast<double>(d.x + d.y + d.z) / 3.0;
  }
}

}  // namespace

std::size_t nearest_box(std::span<const DetailSurface> surfaces, const glm::dvec3& p) {
  std::size_t first = 0;
  double first_distance = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < surfaces.size() && surfaces.size() > 1; ++i) {
    const double distance = surfaces[i].bvh->distance_to_bounds(p);
    if (distance < first_distance) {
      first = i;
      first_distance = distance;
    }
  }
  return first;
}

double area_of(const LatticeMesh& mesh) {
  double area = 0;
  for (const auto& face : mesh.faces) area += face_area(mesh, face);
  return area;
}

void ErrorSum::add(const SurfaceError& error, double area) {
  sum_.max_m = std::max(sum_.max_m, error.max_m);
  sum_.normal_deviation_deg = std::max(sum_.normal_deviation_deg, error.normal_deviation_deg);
  sum_.appearance_m = std::max(sum_.appearance_m, error.appearance_m);
  sum_.mean_m += error.mean_m * area;
  sum_.color_error += error.color_error * area;
  area_ += area;
}

SurfaceError ErrorSum::joint() const {
  SurfaceError error = sum_;
  error.mean_m /= area_;
  error.color_error /= area_;
  return error;
}

std::vector<std::uint16_t> appearance_classes(std::span<const Material> materials) {
  constexpr float kColorApart = 0.08F;
  constexpr float kRoughnessApart = 0.2F;
  constexpr float kMetallicApart = 0.5F;
  std::vector<std::uint16_t> appearances;
  std::vector<const Material*> first_of_class;
  for (const Material& material : materials) {
    std::size_t appearance = 0;
    for (; appearance < first_of_class.size(); ++appearance) {
      const Material& other = *first_of_class[appearance];
      const glm::vec3 d = glm::abs(material.base_color - other.base_color);
      if (std::max({d.x, d.y, d.z}) < kColorApart && std::abs(material.roughness - other.roughness) < kRoughnessApart &&
          std::abs(material.metallic - other.metallic) < kMetallicApart)
        break;
    }
    if (appearance == first_of_class.size()) first_of_class.push_back(&material);
    appearances.push_back(static_cast<std::uint16_t>(appearance));
  }
  return appearances;
}

SurfaceError measure_proxy(const LatticeMesh& proxy, std::span<const DetailSurface> detail,
                           std::span<const Material> materials, std::span<const std::uint16_t> appearances,
                           double step_m, double promise_m) {
  std::vector<Sample> from_proxy;
  add_area_samples(proxy, area_of(proxy), sample_count(proxy.faces.size()), from_proxy);
  add_vertex_samples(proxy, kVerticesMax, from_proxy);

  std::vector<Sample> from_detail;
  std::vector<double> areas;
  double total_area = 0;
  std::size_t total_vertices = 0;
  std::size_t total_faces = 0;
  for (const auto& surface : detail) {
    areas.push_back(area_of(*surface.mesh));
    total_area += areas.back();
    total_vertices += surface.mesh->vertices.size();
    total_faces += surface.mesh->faces.size();
  }
  const std::size_t detail_samples = sample_count(total_faces);
  for (std::size_t i = 0; i < detail.size(); ++i) {
    const auto share = [](double part, double whole, std::size_t count) {
      return static_cast<std::size_t>(std::ceil(part / whole * static_cast<double>(count)));
    };
    add_area_samples(*detail[i].mesh, areas[i], share(areas[i], total_area, detail_samples), from_detail);
    const auto vertices = static_cast<double>(detail[i].mesh->vertices.size());
    add_vertex_samples(*detail[i].mesh, share(vertices, static_cast<double>(total_vertices), kVerticesMax),
                       from_detail);
  }

  const DistanceBvh proxy_bvh(proxy, appearances);
  const DetailSurface proxy_surface = {&proxy, &proxy_bvh};
  Sums sums;
  const std::span<const DetailSurface> proxy_side(&proxy_surface, 1);
  compare(from_proxy, proxy_side, detail, materials, appearances, sums);
  compare(from_detail, detail, proxy_side, materials, appearances, sums);
  SurfaceError error;
  const double count = static_cast<double>(std::max<std::size_t>(sums.count, 1));
  double moved = 0;
  for (const DetailSurface& surface : detail) moved = std::max(moved, surface.moved);
  const double promise = promise_m / step_m;
  DistanceBound bound = bound_distance(proxy, detail, sums.max, promise);
  const double known = bound.distance;
  for (const DetailSurface& surface : detail) {
    const DistanceBound other = bound_distance(*surface.mesh, proxy_side, known, promise);
    bound.distance = std::max(bound.distance, other.distance);
    bound.work += other.work;
    bound.is_loose = bound.is_loose || other.is_loose;
  }
  error.max_m = (bound.distance + moved) * step_m;
  error.work = sums.work + bound.work;
  error.is_loose = sums.is_loose || bound.is_loose;
  error.appearance_m = sums.appearance * step_m;
  error.mean_m = sums.distance / count * step_m;
  error.normal_deviation_deg = std::acos(std::clamp(sums.worst_alignment, 0.0, 1.0)) * 180.0 / std::numbers::pi;
  error.color_error = sums.color / count;
  return error;
}

}  // namespace zc
