// SPDX-License-Identifier: GPL-3.0-or-later
// One object's triangles: quads, boxes, prisms, tubes, in a local frame that may be turned about the vertical.
// Positions are rounded to 2^-10 m when they are added: floats store that grid exactly out to 16 km, so edges that
// touch in the design touch in the file bit by bit, whatever the maths library's last digit.
// Units: metres, z up, counter-clockwise outward. Thread-safe: one object per thread.
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <span>
#include <string>
#include <vector>

#include "baker/generate/materials.h"

namespace zc::generate {

using Vec2 = glm::dvec2;
using Vec3 = glm::dvec3;
using Polygon = std::vector<Vec2>;  // counter-clockwise, not closed

struct Rect {
  double x0 = 0, y0 = 0, x1 = 0, y1 = 0;

  [[nodiscard]] double width() const { return x1 - x0; }
  [[nodiscard]] double height() const { return y1 - y0; }
  [[nodiscard]] Vec2 center() const { return {(x0 + x1) / 2, (y0 + y1) / 2}; }
  [[nodiscard]] Rect inset(double by) const { return {x0 + by, y0 + by, x1 - by, y1 - by}; }
  [[nodiscard]] Polygon polygon() const { return {{x0, y0}, {x1, y0}, {x1, y1}, {x0, y1}}; }
};

// Each edge moved inward by `by`, joined with mitres.
Polygon inset_polygon(std::span<const Vec2> outline, double by);
// Corners of a regular polygon; the first lies at angle `turn`.
Polygon circle(Vec2 center, double radius, int sides, double turn = 0);

struct MeshTriangle {
  std::array<Vec3, 3> corners;
  Mat material;
};

class MeshBuilder {
 public:
  explicit MeshBuilder(std::string name) : name_(std::move(name)) {}

  // Everything added from here on is turned by the heading (unit vector that local +x maps to), then moved to origin.
  void set_frame(Vec3 origin, Vec2 heading = {1, 0});

  void triangle(Vec3 a, Vec3 b, Vec3 c, Mat m);
  void quad(Vec3 a, Vec3 b, Vec3 c, Vec3 d, Mat m);
  // The strip between two chains; its front faces the viewer who sees `low` below `high`, both running to the right.
  // Vertices are joined in the order of their share of the chain's length, so any two counts fit.
  void strip(std::span<const Vec3> low, std::span<const Vec3> high, Mat m);
  // A simple polygon, facing up (or down) at height z. Ear clipping: any shape without holes.
  void cap(std::span<const Vec2> outline, double z, Mat m, bool up = true);
  // The flat ring between an outline, whose first vertex is a convex corner, and a hole; both counter-clockwise.
  void ring(std::span<const Vec2> outer, std::span<const Vec2> hole, double z, Mat m);
  // Vertical walls around an outline, facing out, or in when the outline bounds a hole.
  void walls(std::span<const Vec2> outline, double z0, double z1, Mat m, bool outward = true);
  void prism(std::span<const Vec2> outline, double z0, double z1, Mat side, Mat top);  // closed
  void box(Vec3 low, Vec3 high, Mat m) { box(low, high, m, m); }
  void box(Vec3 low, Vec3 high, Mat side, Mat top);                                       // closed
  void tube(Vec3 from, Vec3 to, double radius_from, double radius_to, int sides, Mat m);  // closed by flat ends
  void torus(Vec3 center, Vec3 axis, double radius, double tube_radius, int segments, int sides, Mat m);
  // An icosphere squeezed to the radii; `bumps` (a factor per vertex) make it less round.
  void blob(Vec3 center, Vec3 radii, bool fine, std::span<const double, 42> bumps, Mat m);

  [[nodiscard]] const std::string& name() const { return name_; }
  [[nodiscard]] std::span<const MeshTriangle> triangles() const { return triangles_; }

 private:
  [[nodiscard]] Vec3 place(Vec3 local) const;

  std::string name_;
  Vec3 origin_ = {0, 0, 0};
  Vec2 heading_ = {1, 0};
  std::vector<MeshTriangle> triangles_;
};

}  // namespace zc::generate
