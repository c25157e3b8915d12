// SPDX-License-Identifier: GPL-3.0-or-later
// Octahedra: Cigolle et al., A Survey of Efficient Representations for Independent Unit Vectors, JCGT 3(2), 2014.
#include "baker/import/tiles/tile_instances.h"

#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include "baker/geo/earth_frame.h"

namespace zc {
namespace {

using Elements = std::optional<std::span<const std::byte>>;

// Nearer to the earth's centre nothing is up.
constexpr double kLeastRadiusM = 1e6;

glm::dvec3 floats_at(std::span<const std::byte> bytes, std::size_t i) {
  return {load_number<float>(bytes, 12 * i), load_number<float>(bytes, 12 * i + 4),
          load_number<float>(bytes, 12 * i + 8)};
}

double unit_at(std::span<const std::byte> bytes, std::size_t at) {
  return load_number<std::uint16_t>(bytes, at) / 65535.0;
}

glm::dvec3 octahedron_at(std::span<const std::byte> bytes, std::size_t i) {
  const double x = 2 * unit_at(bytes, 4 * i) - 1;
  const double y = 2 * unit_at(bytes, 4 * i + 2) - 1;
  const double z = 1 - std::abs(x) - std::abs(y);
  if (z >= 0) return glm::normalize(glm::dvec3(x, y, z));
  return glm::normalize(glm::dvec3(std::copysign(1 - std::abs(y), x), std::copysign(1 - std::abs(x), y), z));
}

// Columns: where the model's x, y and z point.
class Orientations {
 public:
  static Result<Orientations> read(const FeatureTable& table, std::uint64_t count) {
    Orientations of;
    ZC_ASSIGN(of.up_, table.elements("NORMAL_UP", count, 12));
    ZC_ASSIGN(of.right_, table.elements("NORMAL_RIGHT", count, 12));
    if (of.up_.has_value() != of.right_.has_value()) return table.error("NORMAL_UP and NORMAL_RIGHT need each other");
    if (of.up_) return of;
    ZC_ASSIGN(of.up_, table.elements("NORMAL_UP_OCT32P", count, 4));
    ZC_ASSIGN(of.right_, table.elements("NORMAL_RIGHT_OCT32P", count, 4));
    if (of.up_.has_value() != of.right_.has_value())
      return table.error("NORMAL_UP_OCT32P and NORMAL_RIGHT_OCT32P need each other");
    of.are_octahedra_ = of.up_.has_value();
    of.east_north_up_ = !of.up_ && table.is_true("EAST_NORTH_UP");
    return of;
  }

  [[nodiscard]] glm::dmat3 at(std::size_t i, const glm::dvec3& position) const {
    if (east_north_up_) {
      if (!(glm::length(position) > kLeastRadiusM)) return glm::dmat3(1);
      return glm::transpose(glm::dmat3(EarthFrame(geodetic_of(position)).from_geocentric()));
    }
    if (!up_) return glm::dmat3(1);
    const glm::dvec3 up = are_octahedra_ ? octahedron_at(*up_, i) : floats_at(*up_, i);
    const glm::dvec3 right = are_octahedra_ ? octahedron_at(*right_, i) : floats_at(*right_, i);
    const glm::dvec3 forward = glm::cross(right, up);
    if (!(glm::length(forward) > 0)) return glm::dmat3(1);
    return {glm::normalize(right), glm::normalize(up), glm::normalize(forward)};
  }

 private:
  Elements up_;
  Elements right_;
  bool are_octahedra_ = false;
  bool east_north_up_ = false;
};

}  // namespace

Result<std::vector<glm::dmat4>> read_instances(const FeatureTable& table, std::uint64_t limit) {
  ZC_ASSIGN(const std::optional<std::uint64_t> count, table.number("INSTANCES_LENGTH"));
  if (!count) return table.error("i3dm has no INSTANCES_LENGTH");
  if (*count > limit)
    return table.error("i3dm has " + std::to_string(*count) + " instances where " + std::to_string(limit) +
                       " are left of those that an input may have; bake fewer tiles at once");
  ZC_ASSIGN(const std::optional<glm::dvec3> center, table.vector("RTC_CENTER"));
  ZC_ASSIGN(const Elements plain, table.elements("POSITION", *count, 12));
  ZC_ASSIGN(const Elements quantised, table.elements("POSITION_QUANTIZED", *count, 6));
  if (!plain && !quantised) return table.error("i3dm has neither POSITION nor POSITION_QUANTIZED");
  ZC_ASSIGN(const std::optional<glm::dvec3> offset, table.vector("QUANTIZED_VOLUME_OFFSET"));
  ZC_ASSIGN(const std::optional<glm::dvec3> size, table.vector("QUANTIZED_VOLUME_SCALE"));
  if (!plain && (!offset || !size))
    return table.error("POSITION_QUANTIZED needs QUANTIZED_VOLUME_OFFSET and QUANTIZED_VOLUME_SCALE");
  ZC_ASSIGN(const Orientations orientations, Orientations::read(table, *count));
  ZC_ASSIGN(const Elements scales, table.elements("SCALE", *count, 4));
  ZC_ASSIGN(const Elements axis_scales, table.elements("SCALE_NON_UNIFORM", *count, 12));

  std::vector<glm::dmat4> places;
  places.reserve(*count);
  for (std::size_t i = 0; i < *count; ++i) {
    glm::dvec3 position = center.value_or(glm::dvec3(0));
    if (plain)
      position += floats_at(*plain, i);
    else
      position += *offset + *size * glm::dvec3(unit_at(*quantised, 6 * i), unit_at(*quantised, 6 * i + 2),
                                               unit_at(*quantised, 6 * i + 4));
    glm::dvec3 scale(scales ? load_number<float>(*scales, 4 * i) : 1.0F);
    if (axis_scales) scale *= floats_at(*axis_scales, i);
    glm::dmat4 place(orientations.at(i, position));
    for (int axis = 0; axis < 3; ++axis) place[axis] *= scale[axis];
    place[3] = glm::dvec4(position, 1);
    places.push_back(place);
  }
  return places;
}

}  // namespace zc
