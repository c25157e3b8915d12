// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/distance/distance_bvh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <numeric>

#include "baker/distance/triangle_pieces.h"

namespace zc {
namespace {

constexpr std::uint32_t kLeafTriangles = 4;
constexpr std::size_t kPiecesPerTriangle = 4;  // at most, on average
constexpr double kWaste = 8;                   // of a box, against a triangle's share of all boxes' surface
constexpr int kTiedLimit = 256;                // triangles tried for the best aligned
constexpr double kAligned = 1 - 1e-9;          // nothing is better aligned

double squared_distance_to_box(const glm::dvec3& p, const glm::dvec3& low, const glm::dvec3& high) {
  const double x = std::max(std::max(low.x - p.x, p.x - high.x), 0.0);
  const double y = std::max(std::max(low.y - p.y, p.y - high.y), 0.0);
  const double z = std::max(std::max(low.z - p.z, p.z - high.z), 0.0);
  return x * x + y * y + z * z;
}

glm::dvec3 closest_on_triangle(const glm::dvec3& p, const glm::dvec3& a, const glm::dvec3& ab, const glm::dvec3& ac) {
  const glm::dvec3 ap = p - a;
  const double d1 = glm::dot(ab, ap);
  const double d2 = glm::dot(ac, ap);
  if (d1 <= 0 && d2 <= 0) return a;
  const glm::dvec3 bp = ap - ab;
  const double d3 = glm::dot(ab, bp);
  const double d4 = glm::dot(ac, bp);
  if (d3 >= 0 && d4 <= d3) return a + ab;
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return a + ab * (d1 / (d1 - d3));
  const glm::dvec3 cp = ap - ac;
  const double d5 = glm::dot(ab, cp);
  const double d6 = glm::dot(ac, cp);
  if (d6 >= 0 && d5 <= d6) return a + ac;
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return a + ac * (d2 / (d2 - d6));
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) return a + ab + (ac - ab) * ((d4 - d3) / ((d4 - d3) + (d5 - d6)));
  const double scale = 1.0 / (va + vb + vc);
  return a + ab * (vb * scale) + ac * (vc * scale);
}

}  // namespace

double DistanceTriangle::distance(const glm::dvec3& p) const {
  return glm::distance(p, closest_on_triangle(p, a, ab, ac));
}

DistanceBvh::DistanceBvh(const LatticeMesh& mesh, std::span<const std::uint16_t> appearances)
    : bounds_(bounds_of(mesh)) {
  if (mesh.faces.empty()) return;
  const double bearable = kWaste * half_surface(bounds_) / static_cast<double>(mesh.faces.size());
  const std::vector<TrianglePiece> pieces = pieces_of(
      mesh.faces.size(), [&](std::size_t i) { return corners_of(mesh, mesh.faces[i]); }, bearable,
      kPiecesPerTriangle * mesh.faces.size());
  const auto count = static_cast<std::uint32_t>(pieces.size());
  std::vector<std::uint32_t> order(count);
  std::iota(order.begin(), order.end(), 0U);

  struct Task {
    std::uint32_t node, first, count;
  };
  std::vector<Task> tasks = {{0, 0, count}};
  nodes_.resize(1);
  while (!tasks.empty()) {
    const Task task = tasks.back();
    tasks.pop_back();
    LatticeBox box;
    std::array<std::int64_t, 3> low = {INT64_MAX, INT64_MAX, INT64_MAX};
    std::array<std::int64_t, 3> high = {INT64_MIN, INT64_MIN, INT64_MIN};
    for (std::uint32_t i = task.first; i < task.first + task.count; ++i) {
      const LatticeBox& b = pieces[order[i]].box;
      box.add(b);
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const std::int64_t center = std::int64_t{b.min[axis]} + b.max[axis];
        low[axis] = std::min(low[axis], center);
        high[axis] = std::max(high[axis], center);
      }
    }
    Node& node = nodes_[task.node];
    // Floats round: one unit in the last place outwards keeps the box conservative.
    for (int axis = 0; axis < 3; ++axis) {
      const auto at = static_cast<std::size_t>(axis);
      node.min[axis] = std::nextafter(static_cast<float>(box.min[at]), -INFINITY);
      node.max[axis] = std::nextafter(static_cast<float>(box.max[at]), INFINITY);
    }
    if (task.count <= kLeafTriangles) {
      node.first = task.first;
      node.count = task.count;
      continue;
    }
    std::size_t axis = 0;
    for (std::size_t i = 1; i < 3; ++i)
      if (high[i] - low[i] > high[axis] - low[axis]) axis = i;
    const auto begin = order.begin() + task.first;
    const std::uint32_t half = task.count / 2;
    std::nth_element(begin, begin + half, begin + task.count, [&](std::uint32_t a, std::uint32_t b) {
      const std::int64_t ca = std::int64_t{pieces[a].box.min[axis]} + pieces[a].box.max[axis];
      const std::int64_t cb = std::int64_t{pieces[b].box.min[axis]} + pieces[b].box.max[axis];
      return ca != cb ? ca < cb : a < b;
    });
    const auto left = static_cast<std::uint32_t>(nodes_.size());
    node.first = left;
    nodes_.resize(nodes_.size() + 2);
    tasks.push_back({left, task.first, half});
    tasks.push_back({left + 1, task.first + half, task.count - half});
  }
  triangles_.reserve(count);
  for (const std::uint32_t i : order) {
    const LatticeFace& face = mesh.faces[pieces[i].triangle];
    const std::uint16_t appearance = appearances.empty() ? std::uint16_t{0} : appearances[face.material];
    const glm::dvec3 a = to_dvec(mesh.vertices[face.v[0]]);
    const glm::dvec3 ab = to_dvec(mesh.vertices[face.v[1]]) - a;
    const glm::dvec3 ac = to_dvec(mesh.vertices[face.v[2]]) - a;
    triangles_.push_back({a, ab, ac, glm::normalize(glm::cross(ab, ac)), face.material, appearance});
  }
  // Children follow their parents.
  for (std::size_t i = nodes_.size(); i-- > 0;) {
    Node& node = nodes_[i];
    if (node.count == 0) node.appearances = nodes_[node.first].appearances | nodes_[node.first + 1].appearances;
    for (std::uint32_t t = node.first; t < node.first + node.count; ++t)
      node.appearances |= filter_bit(triangles_[t].appearance);
  }
  for (const DistanceTriangle& t : triangles_)
    if (t.appearance >= 64) shared_bits_ |= filter_bit(t.appearance);
}

double DistanceBvh::distance_to_bounds(const glm::dvec3& p) const {
  return std::sqrt(squared_distance_to_box(p, to_dvec(bounds_.min), to_dvec(bounds_.max)));
}

template <class Reach, class Enter, class Visit>
void DistanceBvh::visit_near(const glm::dvec3& p, const Reach& reach, const Enter& enter, const Visit& visit,
                             Work* work) const {
  if (nodes_.empty()) return;
  Work unbounded;
  Work& w = work != nullptr ? *work : unbounded;
  struct Entry {
    std::uint32_t node;
    double squared;
  };
  // Halving by count keeps the tree no deeper than 31 levels.
  std::array<Entry, 64> stack;
  std::size_t top = 0;
  const auto box_distance = [&](std::uint32_t i) {
    return squared_distance_to_box(p, glm::dvec3(nodes_[i].min), glm::dvec3(nodes_[i].max));
  };
  stack[top++] = {0, box_distance(0)};
  bool found_any = false;
  while (top > 0 && !(found_any && w.is_spent())) {
    ++w.done;
    const Entry entry = stack[--top];
    const double limit = reach();
    if (limit < 0) return;
    if (entry.squared > limit * limit) continue;
    const Node& node = nodes_[entry.node];
    if (!enter(node.appearances)) continue;
    if (node.count == 0) {
      Entry near = {node.first, box_distance(node.first)};
      Entry far = {node.first + 1, box_distance(node.first + 1)};
      if (far.squared < near.squared) std::swap(near, far);
      stack[top++] = far;
      stack[top++] = near;
      continue;
    }
    w.done += node.count;
    found_any = true;
    for (std::uint32_t i = node.first; i < node.first + node.count; ++i) visit(triangles_[i]);
  }
}

void DistanceBvh::nearest(const glm::dvec3& p, std::optional<std::uint16_t> appearance, double enough,
                          const DistanceTriangle*& triangle, double& distance, Work* work) const {
  const std::uint64_t wanted = appearance ? filter_bit(*appearance) : ~std::uint64_t{0};
  visit_near(
      p, [&] { return distance > enough ? distance : -1.0; }, [&](std::uint64_t bits) { return (bits & wanted) != 0; },
      [&](const DistanceTriangle& t) {
        if ((appearance && t.appearance != *appearance) || distance <= enough) return;
        const double d = t.distance(p);
        if (d > distance || (d == distance && triangle != nullptr)) return;
        distance = d;
        triangle = &t;
      },
      work);
}

double DistanceBvh::closest_of_appearance(const glm::dvec3& p, std::uint16_t appearance, double limit, double enough,
                                          Work* work) const {
  visit_near(
      p, [&] { return limit > enough ? limit : -1.0; },
      [&](std::uint64_t bits) { return (bits & filter_bit(appearance)) != 0; },
      [&](const DistanceTriangle& t) {
        if (t.appearance == appearance) limit = std::min(limit, t.distance(p));
      },
      work);
  return limit;
}

AppearanceSet DistanceBvh::appearances_within(const glm::dvec3& p, double radius, std::uint16_t known,
                                              Work* work) const {
  AppearanceSet found;
  found.add(known);
  visit_near(
      p, [&] { return radius; }, [&](std::uint64_t bits) { return (bits & (~found.first_bits() | shared_bits_)) != 0; },
      [&](const DistanceTriangle& t) {
        if (!found.has(t.appearance) && t.distance(p) <= radius) found.add(t.appearance);
      },
      work);
  return found;
}

void DistanceBvh::closest(const glm::dvec3& p, const glm::dvec3& normal, double tie, ClosestHit& best,
                          Work* work) const {
  double nearest = best.distance;
  const DistanceTriangle* any = nullptr;
  visit_near(
      p, [&] { return nearest > tie / 2 ? nearest : -1.0; }, [](std::uint64_t) { return true; },
      [&](const DistanceTriangle& t) {
        const double distance = t.distance(p);
        if (distance >= nearest) return;
        nearest = distance;
        any = &t;
      },
      work);
  if (nearest < best.distance - tie) best.alignment = -1;
  best.distance = nearest;
  // Where very many lie on top of each other, one of those that are tried has to do.
  int left = kTiedLimit;
  visit_near(
      p, [&] { return left > 0 && best.alignment < kAligned ? nearest + tie : -1.0; },
      [](std::uint64_t) { return true; },
      [&](const DistanceTriangle& t) {
        --left;
        const double alignment = std::abs(glm::dot(t.normal, normal));
        if (alignment <= best.alignment || t.distance(p) > nearest + tie) return;
        best.alignment = alignment;
        best.material = t.material;
      },
      work);
  if (best.alignment >= 0 || any == nullptr) return;
  best.alignment = std::abs(glm::dot(any->normal, normal));
  best.material = any->material;
}

}  // namespace zc
