// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/import/stray_objects.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <limits>
#include <span>

#include "base/text.h"

namespace zc {
namespace {

constexpr double kFarM = 100'000;  // nothing nearer is stray
constexpr double kGap = 10;        // times as far as the farthest of the others
constexpr std::size_t kNames = 3;

struct Box {
  glm::dvec2 low{std::numeric_limits<double>::infinity()};
  glm::dvec2 high{-std::numeric_limits<double>::infinity()};

  [[nodiscard]] double nearest(const glm::dvec2& p) const { return glm::distance(p, glm::clamp(p, low, high)); }
  [[nodiscard]] double farthest(const glm::dvec2& p) const { return glm::length(glm::max(p - low, high - p)); }
};

// Where half of the objects lie on either side, in x and in y.
glm::dvec2 middle_of(std::span<const Box> boxes) {
  glm::dvec2 middle(0);
  std::vector<double> centers(boxes.size());
  for (int axis = 0; axis < 2; ++axis) {
    for (std::size_t i = 0; i < boxes.size(); ++i) centers[i] = (boxes[i].low[axis] + boxes[i].high[axis]) / 2;
    const auto half = centers.begin() + static_cast<std::ptrdiff_t>((boxes.size() - 1) / 2);
    std::nth_element(centers.begin(), half, centers.end());
    middle[axis] = *half;
  }
  return middle;
}

// Above this, a distance is behind a gap, with no more than half of all; infinite where there is no gap.
double gap_behind(std::vector<double> distances) {
  std::sort(distances.begin(), distances.end());
  for (std::size_t i = (distances.size() + 1) / 2; i < distances.size(); ++i)
    if (distances[i] > kFarM && distances[i] > kGap * distances[i - 1]) return distances[i - 1];
  return std::numeric_limits<double>::infinity();
}

std::string with_commas(double metres) {
  std::string digits = std::to_string(std::llround(metres / 1000));
  for (std::size_t i = digits.size(); i > 3;) digits.insert(i -= 3, ",");
  return digits;
}

std::string line_of(const Scene& scene, const std::vector<std::size_t>& strays, double distance, bool lie) {
  const bool one = strays.size() == 1;
  const std::string verb = lie ? (one ? "lies" : "lie") : (one ? "reaches" : "reach");
  std::string line = std::to_string(strays.size()) + (one ? " object " : " objects ") + verb + " " +
                     with_commas(distance) + " km from the others: ";
  for (std::size_t i = 0; i < std::min(strays.size(), kNames); ++i)
    line += (i > 0 ? ", '" : "'") + printable(scene.objects[strays[i]].id, 80) + "'";
  return line + (strays.size() > kNames ? ", ..." : "");
}

}  // namespace

std::vector<std::string> describe_stray_objects(const Scene& scene) {
  std::vector<Box> boxes(scene.objects.size());
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    const SceneObject& object = scene.objects[i];
    for (std::uint32_t t = object.first_triangle; t < object.first_triangle + object.triangle_count; ++t)
      for (const std::uint32_t v : scene.triangles[t]) {
        boxes[i].low = glm::min(boxes[i].low, glm::dvec2(scene.positions[v]));
        boxes[i].high = glm::max(boxes[i].high, glm::dvec2(scene.positions[v]));
      }
  }
  if (boxes.size() < 2) return {};
  const glm::dvec2 middle = middle_of(boxes);
  std::vector<double> nearest;
  std::vector<double> farthest;
  for (const Box& box : boxes) {
    nearest.push_back(box.nearest(middle));
    farthest.push_back(box.farthest(middle));
  }
  const double gap = gap_behind(farthest);
  std::vector<std::size_t> lying;
  std::vector<std::size_t> reaching;
  double from = std::numeric_limits<double>::infinity();
  double to = 0;
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    if (!(farthest[i] > gap)) continue;
    if (nearest[i] > kFarM) {
      lying.push_back(i);
      from = std::min(from, nearest[i]);
    } else {
      reaching.push_back(i);
      to = std::max(to, farthest[i]);
    }
  }
  std::vector<std::string> lines;
  if (!lying.empty()) lines.push_back(line_of(scene, lying, from, true));
  if (!reaching.empty()) lines.push_back(line_of(scene, reaching, to, false));
  return lines;
}

}  // namespace zc
