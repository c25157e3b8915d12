// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/import/shared/triangulate.h"

#include <CGAL/Constrained_Delaunay_triangulation_2.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Triangulation_face_base_with_info_2.h>
#include <CGAL/Triangulation_vertex_base_with_info_2.h>

#include <exception>
#include <map>
#include <utility>

namespace zc {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using VertexBase = CGAL::Triangulation_vertex_base_with_info_2<std::uint32_t, Kernel>;
using FaceBase =
    CGAL::Constrained_triangulation_face_base_2<Kernel, CGAL::Triangulation_face_base_with_info_2<int, Kernel>>;
using Structure = CGAL::Triangulation_data_structure_2<VertexBase, FaceBase>;
// A corner may lie on another edge, but a crossing that would need a new corner throws.
using Cdt = CGAL::Constrained_Delaunay_triangulation_2<Kernel, Structure,
                                                       CGAL::No_constraint_intersection_requiring_constructions_tag>;

constexpr int kUnmarked = -1;

// Gives every face the number of constraints that separate it from the outside.
void mark_nesting(Cdt& cdt) {
  for (const auto face : cdt.all_face_handles()) face->info() = kUnmarked;
  std::vector<Cdt::Face_handle> level{cdt.infinite_face()};
  for (int nesting = 0; !level.empty(); ++nesting) {
    std::vector<Cdt::Face_handle> border;
    while (!level.empty()) {
      const Cdt::Face_handle face = level.back();
      level.pop_back();
      if (face->info() != kUnmarked) continue;
      face->info() = nesting;
      for (int edge = 0; edge < 3; ++edge) {
        const Cdt::Face_handle next = face->neighbor(edge);
        if (next->info() == kUnmarked) (face->is_constrained(edge) ? border : level).push_back(next);
      }
    }
    level = std::move(border);
  }
}

// Fails, by an exception of CGAL's, when rings cross where no point is. Edges walked an even number of times enclose
// nothing (the bridge from a ring to its hole): only `with_bridges` are they kept.
void insert_rings(std::span<const glm::dvec2> points, std::span<const std::uint32_t> ring_ends, bool with_bridges,
                  Cdt& cdt) {
  std::vector<Cdt::Vertex_handle> handles;
  handles.reserve(points.size());
  std::vector<std::uint32_t> first_at;  // of points at equal places, the first
  first_at.reserve(points.size());
  Cdt::Face_handle hint;
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    const std::size_t before = cdt.number_of_vertices();
    const Cdt::Vertex_handle handle = cdt.insert(Kernel::Point_2(points[i].x, points[i].y), hint);
    if (cdt.number_of_vertices() > before) handle->info() = i;
    hint = handle->face();
    handles.push_back(handle);
    first_at.push_back(handle->info());
  }
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> walks;
  std::uint32_t begin = 0;
  for (const std::uint32_t end : ring_ends) {
    for (std::uint32_t i = begin; i < end; ++i) {
      const std::uint32_t a = first_at[i];
      const std::uint32_t b = first_at[i + 1 < end ? i + 1 : begin];
      if (a != b) ++walks[std::minmax(a, b)];
    }
    begin = end;
  }
  for (const auto& [edge, count] : walks)
    if (with_bridges || count % 2 == 1) cdt.insert_constraint(handles[edge.first], handles[edge.second]);
}

// Appends the triangles that `keep` wants of what the rings part. False, and nothing appended, when they cross.
template <class Keep>
bool triangulate(std::span<const glm::dvec2> points, std::span<const std::uint32_t> ring_ends, bool with_bridges,
                 std::vector<std::array<std::uint32_t, 3>>& out, const Keep& keep) try {
  Cdt cdt;
  insert_rings(points, ring_ends, with_bridges, cdt);
  if (cdt.dimension() < 2) return false;
  mark_nesting(cdt);
  std::vector<std::array<std::uint32_t, 3>> triangles;
  for (const auto face : cdt.finite_face_handles())
    if (keep(face->info()))
      triangles.push_back({face->vertex(0)->info(), face->vertex(1)->info(), face->vertex(2)->info()});
  out.insert(out.end(), triangles.begin(), triangles.end());
  return true;
} catch (const std::bad_alloc&) {
  throw;
} catch (const std::exception&) {
  return false;
}

}  // namespace

bool triangulate_rings(std::span<const glm::dvec2> points, std::span<const std::uint32_t> ring_ends,
                       std::vector<std::array<std::uint32_t, 3>>& out) {
  return triangulate(points, ring_ends, false, out, [](int nesting) { return nesting % 2 == 1; });
}

bool triangulate_between(std::span<const glm::dvec2> points, std::span<const std::uint32_t> ring_ends,
                         std::vector<std::array<std::uint32_t, 3>>& out) {
  return triangulate(points, ring_ends, true, out, [](int) { return true; });
}

}  // namespace zc
