// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/proxy/decimate.h"

#include <OpenMesh/Core/Mesh/TriMesh_ArrayKernelT.hh>
#include <OpenMesh/Core/System/omstream.hh>
#include <OpenMesh/Tools/Decimater/DecimaterT.hh>
#include <OpenMesh/Tools/Decimater/ModHausdorffT.hh>
#include <OpenMesh/Tools/Decimater/ModQuadricT.hh>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "baker/repair/manifold_fans.h"
#include "base/check.h"

namespace zc {
namespace {

constexpr std::size_t kFanFaces = 128;  // around one vertex: every test of a collapse onto it goes round all of them

struct Traits : OpenMesh::DefaultTraits {
  using Point = OpenMesh::Vec3d;
  using Normal = OpenMesh::Vec3d;
};
using Mesh = OpenMesh::TriMesh_ArrayKernelT<Traits>;

double distance_to_segment(const Mesh::Point& p, const Mesh::Point& a, const Mesh::Point& b) {
  const Mesh::Point ab = b - a;
  const double length2 = ab.sqrnorm();
  const double t = length2 > 0 ? std::clamp(((p - a) | ab) / length2, 0.0, 1.0) : 0.0;
  return (a + ab * t - p).norm();
}

// Legality of a collapse besides the Hausdorff bound: feature lines (open borders, material borders) keep their course,
// no face vanishes, turns too far or loses its area.
template <class MeshT>
class ModFeatureT : public OpenMesh::Decimater::ModBaseT<MeshT> {
 public:
  DECIMATING_MODULE(ModFeatureT, MeshT, Feature);

  explicit ModFeatureT(MeshT& mesh) : Base(mesh, true) {}

  void configure(OpenMesh::FPropHandleT<std::uint32_t> tag, const DecimateOptions& options) {
    tag_ = tag;
    options_ = options;
    min_cos_ = std::cos(options.normal_turn_deg * std::numbers::pi / 180.0);
  }

  float collapse_priority(const CollapseInfo& ci) override {
    const bool legal = features_stay(ci) && faces_stay(ci);
    return legal ? float(Base::LEGAL_COLLAPSE) : float(Base::ILLEGAL_COLLAPSE);
  }

 private:
  enum class Feature { kNone, kOpen, kMaterial };

  Feature feature_at(typename Mesh::HalfedgeHandle h) {
    auto& mesh = Base::mesh();
    const auto opposite = mesh.opposite_halfedge_handle(h);
    if (mesh.is_boundary(h) || mesh.is_boundary(opposite)) return Feature::kOpen;
    if (!options_.keep_material_borders) return Feature::kNone;
    return mesh.property(tag_, mesh.face_handle(h)) == mesh.property(tag_, mesh.face_handle(opposite))
               ? Feature::kNone
               : Feature::kMaterial;
  }

  bool features_stay(const CollapseInfo& ci) {
    auto& mesh = Base::mesh();
    int lines = 0;
    bool open = false;
    typename Mesh::VertexHandle other;
    for (typename Mesh::VertexOHalfedgeIter it(mesh, ci.v0); it.is_valid(); ++it) {
      const Feature feature = feature_at(*it);
      if (feature == Feature::kNone) continue;
      ++lines;
      open = open || feature == Feature::kOpen;
      if (mesh.to_vertex_handle(*it) != ci.v1) other = mesh.to_vertex_handle(*it);
    }
    if (lines == 0) return true;
    if (lines != 2 || feature_at(ci.v0v1) == Feature::kNone || !other.is_valid()) return false;
    const double allowed = open ? options_.tolerance : options_.tolerance / 4;
    return distance_to_segment(ci.p0, ci.p1, mesh.point(other)) <= allowed;
  }

  bool faces_stay(const CollapseInfo& ci) {
    auto& mesh = Base::mesh();
    for (typename Mesh::VertexFaceIter it(mesh, ci.v0); it.is_valid(); ++it) {
      if (*it == ci.fl || *it == ci.fr) continue;
      std::array<typename Mesh::Point, 3> p;
      std::size_t i = 0;
      for (typename Mesh::FaceVertexIter v(mesh, *it); v.is_valid(); ++v) p[i++] = *v == ci.v0 ? ci.p1 : mesh.point(*v);
      const auto normal = (p[1] - p[0]) % (p[2] - p[0]);
      const double length = normal.norm();
      // Lattice vertices: half a square step is the least area there is.
      if (length < 0.5) return false;
      if ((normal | mesh.normal(*it)) < min_cos_ * length) return false;
    }
    return true;
  }

  OpenMesh::FPropHandleT<std::uint32_t> tag_;
  DecimateOptions options_;
  double min_cos_ = 0;
};

std::uint32_t tag_of(const LatticeFace& face) { return std::uint32_t{face.material} | (face.ground ? 0x10000U : 0U); }

// OpenMesh reports refused faces on a global stream; they are expected here and handled.
void silence_openmesh() {
  static const bool done = [] {
    ::omerr().disable();
    ::omlog().disable();
    ::omout().disable();
    return true;
  }();
  static_cast<void>(done);
}

}  // namespace

LatticeMesh decimate(LatticeMesh mesh, std::vector<bool> locked, const DecimateOptions& options) {
  ZC_CHECK(locked.size() == mesh.vertices.size());
  if (mesh.faces.empty()) return mesh;
  cut_wide_fans(mesh, kFanFaces, locked);
  silence_openmesh();
  // Small numbers keep the quadrics well conditioned.
  const LatticePoint origin = bounds_of(mesh).min;
  const auto to_point = [&](const LatticePoint& p) {
    return Mesh::Point(double(p[0]) - origin[0], double(p[1]) - origin[1], double(p[2]) - origin[2]);
  };

  ManifoldFans fans = split_into_fans(mesh);
  Mesh half_edges;
  half_edges.request_vertex_status();
  half_edges.request_edge_status();
  half_edges.request_face_status();
  half_edges.request_face_normals();
  OpenMesh::FPropHandleT<std::uint32_t> tag;
  half_edges.add_property(tag);
  std::vector<std::uint32_t> source = fans.source_vertex;
  for (const std::uint32_t v : source) half_edges.add_vertex(to_point(mesh.vertices[v]));
  for (std::size_t i = 0; i < mesh.faces.size(); ++i) {
    std::array<Mesh::VertexHandle, 3> v;
    for (std::size_t k = 0; k < 3; ++k) v[k] = Mesh::VertexHandle(static_cast<int>(fans.face_fans[i][k]));
    Mesh::FaceHandle face = half_edges.add_face(v[0], v[1], v[2]);
    if (!face.is_valid()) {
      for (std::size_t k = 0; k < 3; ++k) {
        source.push_back(mesh.faces[i].v[k]);
        v[k] = half_edges.add_vertex(to_point(mesh.vertices[source.back()]));
      }
      face = half_edges.add_face(v[0], v[1], v[2]);
    }
    ZC_CHECK(face.is_valid());
    half_edges.property(tag, face) = tag_of(mesh.faces[i]);
  }
  for (std::size_t i = 0; i < source.size(); ++i)
    if (locked[source[i]]) half_edges.status(Mesh::VertexHandle(static_cast<int>(i))).set_locked(true);
  half_edges.update_face_normals();

  {
    OpenMesh::Decimater::DecimaterT<Mesh> decimater(half_edges);
    ModFeatureT<Mesh>::Handle feature;
    OpenMesh::Decimater::ModHausdorffT<Mesh>::Handle hausdorff;
    OpenMesh::Decimater::ModQuadricT<Mesh>::Handle quadric;
    decimater.add(feature);
    decimater.add(hausdorff);
    decimater.add(quadric);
    decimater.module(feature).configure(tag, options);
    decimater.module(hausdorff).set_tolerance(options.tolerance);
    decimater.module(quadric).unset_max_err();
    ZC_CHECK(decimater.initialize());
    decimater.decimate_to_faces(0, options.target_faces);
  }

  LatticeMesh out;
  out.vertices.reserve(source.size());
  for (const std::uint32_t v : source) out.vertices.push_back(mesh.vertices[v]);
  for (const auto face : half_edges.faces()) {
    if (half_edges.status(face).deleted()) continue;
    LatticeFace kept;
    std::size_t k = 0;
    for (Mesh::FaceVertexIter v(half_edges, face); v.is_valid(); ++v)
      kept.v[k++] = static_cast<std::uint32_t>(v->idx());
    const std::uint32_t value = half_edges.property(tag, face);
    kept.material = static_cast<std::uint16_t>(value & 0xFFFFU);
    kept.ground = (value >> 16U) != 0;
    out.faces.push_back(kept);
  }
  clean(out);
  return out;
}

}  // namespace zc
