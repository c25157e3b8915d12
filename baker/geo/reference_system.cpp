// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/geo/reference_system.h"

#include <proj.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/matrix.hpp>
#include <glm/trigonometric.hpp>
#include <utility>

#include "baker/geo/earth_frame.h"
#include "base/text.h"

namespace zc {
namespace {

struct ContextEnd {
  void operator()(PJ_CONTEXT* context) const { proj_context_destroy(context); }
};
struct ProjEnd {
  void operator()(PJ* object) const { proj_destroy(object); }
};
using Context = std::unique_ptr<PJ_CONTEXT, ContextEnd>;
using Proj = std::unique_ptr<PJ, ProjEnd>;

constexpr double kDifference_m = 64;  // a city's scale: curvature cancels, and rounding is 1e-11 of it

// Names by which German surveys call the systems of their city models.
constexpr std::array<std::pair<std::string_view, std::string_view>, 7> kSurveyNames = {{
    {"etrs89_utm31", "25831"},
    {"etrs89_utm32", "25832"},
    {"etrs89_utm33", "25833"},
    {"de_dhdn_3gk2", "31466"},
    {"de_dhdn_3gk3", "31467"},
    {"de_dhdn_3gk4", "31468"},
    {"de_dhdn_3gk5", "31469"},
}};

struct Code {
  std::string epsg;
  bool longitude_first = false;
};

// Of a compound, the plane system comes first.
Code code_of(const std::string& name) {
  for (const auto& [survey, code] : kSurveyNames)
    if (name.find(survey) != std::string::npos) return {std::string(code), false};
  for (std::string_view rest = name; !rest.empty();) {
    const std::string_view part = rest.substr(0, rest.find_first_of(",+&"));
    rest.remove_prefix(std::min(rest.size(), part.size() + 1));
    if (part.ends_with("crs84")) return {"4326", true};
    if (part.ends_with("crs84h")) return {"4979", true};
    const std::size_t digits = part.find_last_not_of("0123456789") + 1;  // 0: all of it
    const bool is_epsg = digits == 0 || part.find("epsg") != std::string_view::npos;
    if (is_epsg && digits < part.size()) return {std::string(part.substr(digits)), false};
  }
  return {};
}

bool is_latitude_first(PJ_CONTEXT* context, const PJ* crs) {
  const Proj axes(proj_crs_get_coordinate_system(context, crs));
  const char* direction = nullptr;
  return axes &&
         proj_cs_get_axis_info(context, axes.get(), 0, nullptr, nullptr, &direction, nullptr, nullptr, nullptr,
                               nullptr) != 0 &&
         direction != nullptr && lower(direction) == "north";
}

double unit_of(PJ_CONTEXT* context, const PJ* crs) {
  const Proj axes(proj_crs_get_coordinate_system(context, crs));
  double unit = 1;
  if (axes) proj_cs_get_axis_info(context, axes.get(), 0, nullptr, nullptr, nullptr, &unit, nullptr, nullptr, nullptr);
  return unit;
}

}  // namespace

// Between the plane of a system and longitude and latitude of WGS 84, in degrees.
struct ReferenceSystem::Conversion {
  Context context;
  Proj to_degrees;
  Proj geoid;  // none: heights are ellipsoidal

  // Of sea level above the ellipsoid; none where the grid has none.
  [[nodiscard]] double geoid_height(double lon_deg, double lat_deg) const {
    if (!geoid) return 0;
    const PJ_COORD at = proj_trans(geoid.get(), PJ_FWD, proj_coord(glm::radians(lon_deg), glm::radians(lat_deg), 0, 0));
    return std::isfinite(at.xyz.z) ? at.xyz.z : 0;
  }
};

ReferenceSystem::ReferenceSystem(std::string_view name) : name_(name), key_(name) {
  if (name.empty()) return;
  kind_ = Kind::kUnknown;
  if (const auto frame = EarthFrame::parse(name)) {
    kind_ = Kind::kEastNorthUp;
    frame_ = {frame->from_geocentric(), glm::inverse(frame->from_geocentric())};
    return;
  }
  const Code code = code_of(lower(name));
  if (code.epsg.empty()) return;
  key_ = (code.longitude_first ? "CRS84:" : "EPSG:") + code.epsg;
  auto conversion = std::make_shared<Conversion>();
  conversion->context.reset(proj_context_create());
  PJ_CONTEXT* const context = conversion->context.get();
  proj_log_level(context, PJ_LOG_NONE);
  proj_context_set_enable_network(context, 0);
  const Proj whole(proj_create_from_database(context, "EPSG", code.epsg.c_str(), PJ_CATEGORY_CRS, 0, nullptr));
  if (!whole) return;
  const Proj first(proj_get_type(whole.get()) == PJ_TYPE_COMPOUND_CRS ? proj_crs_get_sub_crs(context, whole.get(), 0)
                                                                      : proj_clone(context, whole.get()));
  if (!first) return;
  // A compound is its plane system: heights are above sea level in both.
  if (const char* plane = proj_get_id_code(first.get(), 0); plane != nullptr && !code.longitude_first)
    key_ = std::string("EPSG:") + plane;
  const PJ_TYPE type = proj_get_type(first.get());
  if (type == PJ_TYPE_GEOCENTRIC_CRS) {
    kind_ = Kind::kGeocentric;
    return;
  }
  if (type != PJ_TYPE_PROJECTED_CRS && type != PJ_TYPE_GEOGRAPHIC_2D_CRS && type != PJ_TYPE_GEOGRAPHIC_3D_CRS) return;
  const Proj degrees(proj_create_from_database(context, "EPSG", "4326", PJ_CATEGORY_CRS, 0, nullptr));
  if (!degrees) return;
  const Proj operation(proj_create_crs_to_crs_from_pj(context, first.get(), degrees.get(), nullptr, nullptr));
  if (!operation) return;
  conversion->to_degrees.reset(proj_normalize_for_visualization(context, operation.get()));
  if (!conversion->to_degrees) return;
  if (type != PJ_TYPE_GEOGRAPHIC_3D_CRS)
    conversion->geoid.reset(proj_create(context, "+proj=vgridshift +grids=egm96_15.gtx +multiplier=1"));
  kind_ = type == PJ_TYPE_PROJECTED_CRS ? Kind::kProjected : Kind::kGeographic;
  latitude_first_ = kind_ == Kind::kGeographic && !code.longitude_first && is_latitude_first(context, first.get());
  if (kind_ == Kind::kProjected) unit_m_ = unit_of(context, first.get());
  conversion_ = std::move(conversion);
}

bool ReferenceSystem::is_metric() const {
  return kind_ != Kind::kGeographic && kind_ != Kind::kGeocentric && unit_m_ == 1;
}

std::optional<glm::dvec3> ReferenceSystem::to_geocentric(const glm::dvec3& point) const {
  if (frame_) return glm::dvec3(frame_->to_geocentric * glm::dvec4(point, 1));
  if (kind_ == Kind::kGeocentric) return point;
  if (!conversion_) return std::nullopt;
  const PJ_COORD in = latitude_first_ ? proj_coord(point.y, point.x, 0, 0) : proj_coord(point.x, point.y, 0, 0);
  const PJ_COORD out = proj_trans(conversion_->to_degrees.get(), PJ_FWD, in);
  if (!(std::abs(out.xy.x) <= 360 && std::abs(out.xy.y) <= 90)) return std::nullopt;
  return geocentric_of({out.xy.x, out.xy.y, point.z * unit_m_ + conversion_->geoid_height(out.xy.x, out.xy.y)});
}

std::optional<glm::dvec3> ReferenceSystem::from_geocentric(const glm::dvec3& point) const {
  if (frame_) return glm::dvec3(frame_->from_geocentric * glm::dvec4(point, 1));
  if (kind_ == Kind::kGeocentric) return point;
  if (!conversion_) return std::nullopt;
  const Geodetic place = geodetic_of(point);
  const PJ_COORD out =
      proj_trans(conversion_->to_degrees.get(), PJ_INV, proj_coord(place.lon_deg, place.lat_deg, 0, 0));
  if (!std::isfinite(out.xy.x) || !std::isfinite(out.xy.y)) return std::nullopt;
  const double z = (place.height_m - conversion_->geoid_height(place.lon_deg, place.lat_deg)) / unit_m_;
  return latitude_first_ ? glm::dvec3(out.xy.y, out.xy.x, z) : glm::dvec3(out.xy.x, out.xy.y, z);
}

std::optional<glm::dmat4> ReferenceSystem::geocentric_at(const glm::dvec3& point) const {
  const auto origin = to_geocentric(point);
  if (!origin || !is_metric()) return std::nullopt;
  glm::dmat4 matrix(1);
  if (frame_) {
    matrix = frame_->to_geocentric;
  } else {
    for (int axis = 0; axis < 3; ++axis) {
      glm::dvec3 step(0);
      step[axis] = kDifference_m;
      const auto ahead = to_geocentric(point + step);
      const auto behind = to_geocentric(point - step);
      if (!ahead || !behind) return std::nullopt;
      matrix[axis] = glm::dvec4((*ahead - *behind) / (2 * kDifference_m), 0);
    }
  }
  matrix[3] = glm::dvec4(*origin, 1);
  return matrix;
}

}  // namespace zc
