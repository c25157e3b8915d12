// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/proxy/vertex_collapse.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <numbers>
#include <optional>
#include <queue>

#include "baker/distance/hausdorff_bound.h"
#include "baker/proxy/collapse_reference.h"
#include "baker/proxy/quadric.h"
#include "base/check.h"

namespace zc {
namespace {

constexpr double kBorderWeight = 0.1;   // of a border edge's square, against areas
constexpr double kLengthWeight = 1e-3;  // of a collapse's squared length: settles what costs nothing else
constexpr double kLeastArea = 0.25;     // squared length of a cross product: half a square step is the least there is
constexpr std::uint32_t kBoundPieces = 2000;
constexpr std::uint32_t kCheckPieces = 20000;
constexpr std::uint32_t kStarPieces = 100;
constexpr double kStarNear = 0.1;        // of the tolerance
constexpr double kStarMargin = 0.02;     // of that
constexpr std::size_t kStarFaces = 512;  // what has more around it is not worth the time
constexpr std::size_t kFewTargets = 32;
constexpr std::size_t kStarWork = 50000;   // nor is what takes more distances, with more faces than a few
constexpr double kMargin = 0.5;            // of the tolerance
constexpr double kLeastPiece = 0.03;       // of the tolerance
constexpr double kSampleTolerance = 0.97;  // of the tolerance: a piece around a sample is then within it
constexpr double kNear = 0.01;             // of the tolerance: no search for what is nearer still
constexpr int kRounds = 6;
constexpr std::uint64_t kFaceVisitsPerWork =
    8;  // visits of a face of a list are so many times cheaper than of one of a tree
// Twice what the zones of the cities that we know take at most: seven million with 635 faces, ten with 2,968.
constexpr std::uint64_t kLeastWork = 16'000'000;
constexpr std::uint64_t kWorkPerFace = 8'000;

using Face = std::uint32_t;
using Vertex = std::uint32_t;
using Sample = CollapseReference::Sample;

bool has_vertex(const std::array<Vertex, 3>& v, Vertex x) { return v[0] == x || v[1] == x || v[2] == x; }

std::array<Vertex, 3> replaced(std::array<Vertex, 3> v, Vertex from, Vertex to) {
  for (Vertex& x : v)
    if (x == from) x = to;
  return v;
}

bool same_vertices(const std::array<Vertex, 3>& a, const std::array<Vertex, 3>& b) {
  return has_vertex(a, b[0]) && has_vertex(a, b[1]) && has_vertex(a, b[2]);
}

DistanceTriangle triangle_of(const Corners& c) {
  DistanceTriangle t;
  t.a = c[0];
  t.ab = c[1] - c[0];
  t.ac = c[2] - c[0];
  t.normal = glm::normalize(glm::cross(t.ab, t.ac));
  return t;
}

// One run over all vertices, the cheapest collapse first.
class Collapser {
 public:
  Collapser(const CollapseReference& reference, const std::vector<bool>& locked, const CollapseOptions& options,
            Work& work)
      : work_(work),
        reference_(reference),
        options_(options),
        locked_(locked),
        min_cos_(std::cos(options.normal_turn_deg * std::numbers::pi / 180.0)),
        faces_(reference.mesh().faces.size()),
        vertices_(reference.mesh().vertices.size()),
        left_(faces_.size()) {
    const LatticeMesh& mesh = reference.mesh();
    const LatticePoint origin = bounds_of(mesh).min;
    // Small numbers keep the quadrics well conditioned.
    origin_ = {origin[0], origin[1], origin[2]};
    for (Vertex v = 0; v < vertices_.size(); ++v) vertices_[v].point = reference.point(v);
    for (Face f = 0; f < faces_.size(); ++f) {
      FaceState& face = faces_[f];
      face.v = mesh.faces[f].v;
      const Corners c = corners(face.v);
      const glm::dvec3 cross = glm::cross(c[1] - c[0], c[2] - c[0]);
      const double length = glm::length(cross);
      face.normal = cross / length;
      for (const Vertex v : face.v) {
        vertices_[v].faces.push_back(f);
        vertices_[v].quadric.add_plane(face.normal, c[0] - origin_, length / 6);
      }
    }
    for_each_edge(reference.edges(), [&](std::span<const FaceEdge> edge) { hold_border(edge); });
    for (std::uint32_t s = 0; s < reference.samples().size(); ++s)
      faces_[reference.samples()[s].face].samples.push_back(s);
  }

  LatticeMesh run() {
    for (Vertex u = 0; u < vertices_.size(); ++u) push(u);
    while (!queue_.empty() && left_ > options_.target_faces && !work_.is_spent()) {
      const Candidate next = queue_.top();
      queue_.pop();
      if (vertices_[next.u].version == next.version && is_legal(next.u, next.v)) apply(next.u, next.v);
    }
    LatticeMesh out;
    out.vertices = reference_.mesh().vertices;
    for (Face f = 0; f < faces_.size(); ++f) {
      if (!faces_[f].alive) continue;
      LatticeFace face = reference_.mesh().faces[f];
      face.v = faces_[f].v;
      out.faces.push_back(face);
    }
    return out;
  }

  // Where it lies in the reference.
  [[nodiscard]] bool is_as_before(Face f) const {
    return faces_[f].alive && faces_[f].v == reference_.mesh().faces[f].v;
  }

 private:
  struct FaceState {
    std::array<Vertex, 3> v = {};
    glm::dvec3 normal = {};  // of the beginning
    double error = 0;        // bound of how far it is from the reference
    bool alive = true;
    std::vector<std::uint32_t> samples;
  };
  struct VertexState {
    glm::dvec3 point = {};
    Quadric quadric;
    std::vector<Face> faces;
    std::uint32_t version = 0;  // candidates of older ones are stale
  };
  struct Candidate {
    double cost;
    Vertex u, v;  // u moves to v
    std::uint32_t version;
    bool operator<(const Candidate& o) const {  // the queue's top is the greatest
      if (cost != o.cost) return cost > o.cost;
      return u != o.u ? u > o.u : v > o.v;
    }
  };
  struct Move {
    std::uint32_t sample;
    Face face;
  };

  [[nodiscard]] Corners corners(const std::array<Vertex, 3>& v) const {
    return {vertices_[v[0]].point, vertices_[v[1]].point, vertices_[v[2]].point};
  }

  // Open edges and edges between appearances keep their course.
  void hold_border(std::span<const FaceEdge> edge) {
    bool border = edge.size() == 1;
    for (const FaceEdge& e : edge)
      border = border || reference_.appearance(e.face) != reference_.appearance(edge[0].face);
    if (!border) return;
    const glm::dvec3 a = vertices_[edge[0].low].point;
    const glm::dvec3 ab = vertices_[edge[0].high].point - a;
    for (const FaceEdge& e : edge) {
      const glm::dvec3 across = glm::normalize(glm::cross(faces_[e.face].normal, ab));
      Quadric quadric;
      quadric.add_plane(across, a - origin_, kBorderWeight * glm::dot(ab, ab));
      vertices_[e.low].quadric += quadric;
      vertices_[e.high].quadric += quadric;
    }
  }

  void push(Vertex u) {
    VertexState& from = vertices_[u];
    ++from.version;
    if (locked_[u] || from.faces.size() > kStarFaces) return;
    neighbours_.clear();
    for (const Face f : from.faces)
      for (const Vertex v : faces_[f].v)
        if (v != u) neighbours_.push_back(v);
    std::ranges::sort(neighbours_);
    neighbours_.erase(std::unique(neighbours_.begin(), neighbours_.end()), neighbours_.end());
    for (const Vertex v : neighbours_) {
      const glm::dvec3 step = vertices_[v].point - from.point;
      const double cost = from.quadric.at(vertices_[v].point - origin_) + kLengthWeight * glm::dot(step, step);
      queue_.push({cost, u, v, from.version});
    }
    work_.done += from.faces.size();
  }

  // Sorts u's faces into those that vanish and those that move, and returns whether the latter may.
  bool sort_faces(Vertex u, Vertex v) {
    vanishing_.clear();
    moving_.clear();
    const double narrow = options_.tolerance;
    for (const Face f : vertices_[u].faces) {
      const FaceState& face = faces_[f];
      work_.done += 1 + (vertices_[v].faces.size() + moving_.size()) / kFaceVisitsPerWork;
      if (has_vertex(face.v, v)) {
        vanishing_.push_back(f);
        continue;
      }
      const std::array<Vertex, 3> moved = replaced(face.v, u, v);
      const Corners c = corners(moved);
      const glm::dvec3 cross = glm::cross(c[1] - c[0], c[2] - c[0]);
      const double length2 = glm::dot(cross, cross);
      if (length2 < kLeastArea) return false;
      const bool turns = glm::dot(cross, face.normal) < min_cos_ * std::sqrt(length2);
      if (turns && (narrowest(c) > narrow || narrowest(corners(face.v)) > narrow)) return false;
      const auto is_twin = [&](Face other) { return same_vertices(moved, faces_[other].v); };
      const auto is_moved_twin = [&](Face other) { return same_vertices(moved, replaced(faces_[other].v, u, v)); };
      if (std::ranges::any_of(vertices_[v].faces, is_twin) || std::ranges::any_of(moving_, is_moved_twin)) {
        vanishing_.push_back(f);
      } else {
        moving_.push_back(f);
      }
    }
    return true;
  }

  [[nodiscard]] int faces_at(Vertex a, Vertex b) const {
    int count = 0;
    work_.done += 1 + vertices_[a].faces.size() / kFaceVisitsPerWork;
    for (const Face f : vertices_[a].faces) count += has_vertex(faces_[f].v, b) ? 1 : 0;
    return count;
  }

  [[nodiscard]] bool vanishes(Face f) const { return std::ranges::find(vanishing_, f) != vanishing_.end(); }

  // An open edge there is at most that of a plate, or of what a wall hides.
  [[nodiscard]] bool lies_at_wide_faces(Vertex a, Vertex b) const {
    const glm::dvec3& p = vertices_[a].point;
    const glm::dvec3& q = vertices_[b].point;
    return reference_.is_at_wide_faces(p) && reference_.is_at_wide_faces(q) &&
           reference_.is_at_wide_faces((p + q) * 0.5);
  }

  // Whether no edge of a bar opens, and none between locked vertices is lost.
  [[nodiscard]] bool edges_stay(Vertex u, Vertex v) const {
    const auto stays = [&](Vertex a, Vertex b, int before, int before_too, int after) {
      if (after == 0) return !(locked_[a] && locked_[b]);
      return after > 1 || before == 1 || before_too == 1 || lies_at_wide_faces(a, b);
    };
    for (const Face f : vanishing_) {
      for (const Vertex w : faces_[f].v) {
        if (w == u || w == v) continue;
        int after = 0;  // of the edge v, w
        work_.done += 1 + (vertices_[v].faces.size() + moving_.size()) / kFaceVisitsPerWork;
        for (const Face g : vertices_[v].faces) after += has_vertex(faces_[g].v, w) && !vanishes(g) ? 1 : 0;
        for (const Face g : moving_) after += has_vertex(faces_[g].v, w) ? 1 : 0;
        if (!stays(v, w, faces_at(u, w), faces_at(v, w), after)) return false;
      }
      if (has_vertex(faces_[f].v, v)) continue;
      // A twin: its edge across u loses a face.
      std::array<Vertex, 2> across = {};
      std::size_t n = 0;
      for (const Vertex w : faces_[f].v)
        if (w != u) across[n++] = w;
      int after = 0;
      work_.done += 1 + vertices_[across[0]].faces.size() / kFaceVisitsPerWork;
      for (const Face g : vertices_[across[0]].faces)
        after += has_vertex(faces_[g].v, across[1]) && !vanishes(g) ? 1 : 0;
      const int before = faces_at(across[0], across[1]);
      if (!stays(across[0], across[1], before, before, after)) return false;
    }
    return true;
  }

  // Finds every sample of u's faces a face that is near enough after the collapse.
  bool samples_stay(Vertex u, Vertex v) {
    moves_.clear();
    const double limit = kSampleTolerance * options_.tolerance;
    targets_.clear();
    const auto add_target = [&](Face f) {
      targets_.push_back({f, triangle_of(corners(replaced(faces_[f].v, u, v))), reference_.appearance(f)});
    };
    for (const Face f : moving_) add_target(f);
    for (const Face f : vertices_[v].faces)
      if (!vanishes(f)) add_target(f);
    std::size_t samples = 0;
    for (const Face f : vertices_[u].faces) samples += faces_[f].samples.size();
    if (targets_.size() > kFewTargets && samples * targets_.size() > kStarWork) return false;
    for (const Face f : vertices_[u].faces) {
      for (const std::uint32_t s : faces_[f].samples) {
        const Sample& sample = reference_.samples()[s];
        double best = std::numeric_limits<double>::infinity();
        Face face = 0;
        for (const TargetFace& target : targets_) {
          if (!sample.appearances.has(target.appearance)) continue;
          const double distance = target.triangle.distance(sample.point);
          ++work_.done;
          if (distance < best) {
            best = distance;
            face = target.face;
            if (best < 0.5) break;
          }
        }
        if (best > limit) return false;
        moves_.push_back({s, face});
      }
    }
    return true;
  }

  // Whether the faces that move stay near the reference, and how near.
  bool surface_stays(Vertex u, Vertex v) {
    errors_.clear();
    for (const Face f : moving_) {
      const Corners moved = corners(replaced(faces_[f].v, u, v));
      double error = error_by_star(u, f, moved);
      if (error > options_.tolerance) {
        const HausdorffBound found = bound_to_reference(f, moved);
        if (!found.within) return false;
        error = found.bound;
      }
      errors_.push_back(error);
    }
    return true;
  }

  // Bound from those of u's faces before the collapse: where they lie in one plane, nothing new is to be found out.
  double error_by_star(Vertex u, Face f, const Corners& moved) {
    star_.clear();
    double before = 0;
    for (const Face g : vertices_[u].faces) {
      if (reference_.appearance(g) != reference_.appearance(f)) continue;
      before = std::max(before, faces_[g].error);
      star_.push_back(triangle_of(corners(faces_[g].v)));
    }
    const double enough = std::min(kStarNear * options_.tolerance, options_.tolerance - before);
    if (enough <= 0) return std::numeric_limits<double>::infinity();
    const HausdorffBound found = hausdorff_bound(
        moved, {enough, kStarMargin * enough, kLeastPiece * options_.tolerance, kStarPieces, true, &work_},
        [&](const glm::dvec3& p, double& distance) {
          const DistanceTriangle* nearest = nullptr;
          work_.done += star_.size();
          for (const DistanceTriangle& t : star_) {
            const double d = t.distance(p);
            if (d >= distance) continue;
            distance = d;
            nearest = &t;
          }
          return nearest;
        });
    return found.within ? before + found.bound : std::numeric_limits<double>::infinity();
  }

  [[nodiscard]] HausdorffBound bound_to_reference(Face f, const Corners& moved) const {
    const double tolerance = options_.tolerance;
    const std::uint16_t appearance = reference_.appearance(f);
    return hausdorff_bound(moved, {tolerance, kMargin * tolerance, kLeastPiece * tolerance, kBoundPieces, true, &work_},
                           [&](const glm::dvec3& p, double& distance) {
                             const DistanceTriangle* found = nullptr;
                             double near = tolerance;
                             reference_.bvh().nearest(p, appearance, kNear * tolerance, found, near, &work_);
                             if (found != nullptr) distance = near;
                             return found;
                           });
  }

  bool is_legal(Vertex u, Vertex v) {
    if (vertices_[u].faces.size() + vertices_[v].faces.size() > kStarFaces) return false;
    return sort_faces(u, v) && edges_stay(u, v) && samples_stay(u, v) && surface_stays(u, v);
  }

  void apply(Vertex u, Vertex v) {
    for (const Face f : vertices_[u].faces) faces_[f].samples.clear();
    for (const Face f : vanishing_) {
      faces_[f].alive = false;
      for (const Vertex w : faces_[f].v)
        if (w != u) {
          work_.done += 1 + vertices_[w].faces.size() / kFaceVisitsPerWork;
          std::erase(vertices_[w].faces, f);
        }
    }
    left_ -= vanishing_.size();
    for (std::size_t i = 0; i < moving_.size(); ++i) {
      FaceState& face = faces_[moving_[i]];
      face.v = replaced(face.v, u, v);
      face.error = errors_[i];
      vertices_[v].faces.push_back(moving_[i]);
    }
    for (const Move& move : moves_) faces_[move.face].samples.push_back(move.sample);
    vertices_[v].quadric += vertices_[u].quadric;
    vertices_[u].faces.clear();
    ++vertices_[u].version;
    std::vector<Vertex> around = {v};
    for (const Face f : moving_) around.insert(around.end(), faces_[f].v.begin(), faces_[f].v.end());
    for (const Face f : vanishing_)
      std::ranges::copy_if(faces_[f].v, std::back_inserter(around), [&](Vertex w) { return w != u; });
    std::ranges::sort(around);
    around.erase(std::unique(around.begin(), around.end()), around.end());
    for (const Vertex w : around) push(w);
  }

  struct TargetFace {
    Face face = 0;
    DistanceTriangle triangle;
    std::uint16_t appearance = 0;
  };

  Work& work_;
  const CollapseReference& reference_;
  CollapseOptions options_;
  const std::vector<bool>& locked_;
  double min_cos_;
  glm::dvec3 origin_ = {};
  std::vector<FaceState> faces_;
  std::vector<VertexState> vertices_;
  std::size_t left_;
  std::priority_queue<Candidate> queue_;
  // Of the collapse that is tried.
  std::vector<Vertex> neighbours_;
  std::vector<Face> vanishing_;
  std::vector<Face> moving_;
  std::vector<TargetFace> targets_;
  std::vector<DistanceTriangle> star_;
  std::vector<double> errors_;  // of moving_
  std::vector<Move> moves_;
};

// Adds samples where the reference is not within the tolerance of `result`; false: there are none.
bool add_samples_outside(CollapseReference& reference, const Collapser& collapser, const LatticeMesh& result,
                         Work& work) {
  const DistanceBvh bvh(result);
  const double tolerance = reference.tolerance();
  const HausdorffLimits limits = {tolerance, kMargin * tolerance, kLeastPiece * tolerance, kCheckPieces, false, &work};
  bool added = false;
  for (Face f = 0; f < reference.mesh().faces.size(); ++f) {
    if (collapser.is_as_before(f)) continue;
    const HausdorffBound found = hausdorff_bound(
        corners_of(reference.mesh(), reference.mesh().faces[f]), limits, [&](const glm::dvec3& p, double& distance) {
          const DistanceTriangle* triangle = nullptr;
          bvh.nearest(p, std::nullopt, kNear * tolerance, triangle, distance, &work);
          return triangle;
        });
    if (found.within) continue;
    reference.add_sample(found.outside, f);
    added = true;
  }
  return added;
}

}  // namespace

Collapsed collapse_vertices(const LatticeMesh& mesh, const std::vector<bool>& locked,
                            std::span<const std::uint16_t> appearances, const CollapseOptions& options) {
  ZC_CHECK(locked.size() == mesh.vertices.size());
  if (mesh.faces.empty()) return {mesh, {}};
  const std::uint64_t limit = kLeastWork + kWorkPerFace * mesh.faces.size();
  Work work{limit};
  bool was_spent = false;
  CollapseReference reference(mesh, appearances, options.tolerance, work);
  for (int round = 0; round < kRounds && !work.is_spent(); ++round) {
    // A quarter of what is left is for the check.
    work.limit = limit - (limit - work.done) / 4;
    Collapser collapser(reference, locked, options, work);
    Collapsed out = {collapser.run(), {}};
    was_spent = was_spent || work.is_spent();
    work.limit = limit;
    if (!add_samples_outside(reference, collapser, out.mesh, work)) {
      clean(out.mesh);
      out.work = work;
      if (was_spent) out.work.limit = out.work.done;
      return out;
    }
  }
  return {mesh, work};
}

}  // namespace zc
