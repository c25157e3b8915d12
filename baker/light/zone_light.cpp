// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/light/zone_light.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/mat4x4.hpp>
#include <glm/matrix.hpp>
#include <numeric>
#include <tuple>
#include <utility>

#include "baker/light/quantise_light.h"

namespace zc {
namespace {

constexpr float kSunDistanceM = 1e6F;
constexpr std::size_t kRays = 48;
// Samples lie this far from a corner towards the others, so that what touches the corner does not hide everything.
constexpr float kInset = 1.0F / 6;
// Corners at one point share their samples when their normals are closer than this.
constexpr float kSmoothCosine = 0.94F;
constexpr int kBounceRounds = 24;
// Corners lie where other things begin: of a triangle longer than this, bounced light is sampled all over it.
constexpr float kBounceSpacingM = 1.5F;
constexpr int kBounceMaxRows = 4;
// A surface this close to a proxy is what it stands for, whichever way it faces.
constexpr float kSameSurfaceM = 0.1F;
// For the sun, a triangle is sampled so densely, of a coarse proxy half as densely as it is exact: no shadow that is
// wider than this everywhere is overlooked. Where that takes more points than two to the power of kSunMaxHalvings,
// nothing is said.
constexpr float kSunSpacingM = 0.4F;
constexpr int kSunMaxHalvings = 14;

// Cosine-weighted over the upper half of z: Hammersley points, Malley's method.
const std::array<glm::vec3, kRays>& hemisphere() {
  static const std::array<glm::vec3, kRays> rays = [] {
    std::array<glm::vec3, kRays> out{};
    for (std::uint32_t i = 0; i < kRays; ++i) {
      std::uint32_t bits = i;
      double inverse = 0;
      for (double digit = 0.5; bits != 0; bits >>= 1U, digit /= 2)
        if ((bits & 1U) != 0) inverse += digit;
      const double radius = std::sqrt((i + 0.5) / kRays);
      const double turn = 2 * 3.14159265358979 * inverse;
      out[i] = glm::vec3(radius * std::cos(turn), radius * std::sin(turn), std::sqrt(1 - radius * radius));
    }
    return out;
  }();
  return rays;
}

// A frame whose z is `n`. Source: Duff et al. 2017, "Building an orthonormal basis, revisited".
glm::mat3 frame_of(const glm::vec3& n) {
  const float sign = std::copysign(1.0F, n.z);
  const float a = -1 / (sign + n.z);
  const float b = n.x * n.y * a;
  return {{1 + sign * n.x * n.x * a, sign * b, -sign * n.x}, {b, sign + n.y * n.y * a, -n.y}, n};
}

// What one point receives.
struct Received {
  float sky = 0;                              // share of all rays that hit nothing
  float hidden = 0;                           // and the rest, which spreads with the bounced light
  glm::vec3 around{0};                        // sum of the colours hit, over all rays
  std::array<glm::vec3, kBounceSuns> sent{};  // of sunlight sent on by them, per sun

  void scale(float factor) {
    const Received unscaled = *this;
    *this = {};
    add(unscaled, factor);
  }
  void add(const Received& o, float factor) {
    sky += o.sky * factor;
    hidden += o.hidden * factor;
    around += o.around * factor;
    for (std::size_t k = 0; k < kBounceSuns; ++k) sent[k] += o.sent[k] * factor;
  }
};

// Coefficients of the least squares fit of a + b · sun to values at the suns.
const std::array<glm::dvec4, kBounceSuns>& fit_rows() {
  static const std::array<glm::dvec4, kBounceSuns> rows = [] {
    glm::dmat4 normal(0);
    for (const glm::vec3& s : bounce_suns()) {
      const glm::dvec4 v(1, s.x, s.y, s.z);
      normal += glm::outerProduct(v, v);
    }
    const glm::dmat4 inverse = glm::inverse(normal);
    std::array<glm::dvec4, kBounceSuns> out{};
    for (std::size_t k = 0; k < kBounceSuns; ++k)
      out[k] = inverse * glm::dvec4(1, bounce_suns()[k].x, bounce_suns()[k].y, bounce_suns()[k].z);
    return out;
  }();
  return rows;
}

std::uint32_t quantised(float value, std::uint32_t limit) {
  return static_cast<std::uint32_t>(std::lround(std::clamp(value, 0.0F, 1.0F) * static_cast<float>(limit)));
}

// Octahedral, 4 bits each.
std::uint32_t pack_direction(const glm::vec3& direction) {
  const glm::vec3 n = direction / (std::abs(direction.x) + std::abs(direction.y) + std::abs(direction.z));
  glm::vec2 p(n.x, n.y);
  if (n.z < 0) p = {(1 - std::abs(n.y)) * (n.x >= 0 ? 1.0F : -1.0F), (1 - std::abs(n.x)) * (n.y >= 0 ? 1.0F : -1.0F)};
  return quantised(p.x * 0.5F + 0.5F, 15) | quantised(p.y * 0.5F + 0.5F, 15) << 4U;
}

class ZoneLight {
 public:
  ZoneLight(const ZoneMesh& mesh, const NodeRecord& node, const LightScene& scene, const std::optional<SunAngles>& sun,
            double step_m)
      : mesh_(mesh), scene_(scene), step_m_(step_m * std::exp2(node.step_shift)) {
    if (sun) sun_ = sun_direction(*sun);
    // Cities have walls in layers, one closely before the other: what is lit is the outermost.
    reach_m_ =
        node.is_detail() ? kSameSurfaceM : node.error_max_m + static_cast<float>(step_m * std::exp2(node.step_shift));
    points_.reserve(mesh.vertices.size());
    for (const auto& q : mesh.vertices) {
      glm::vec3 p;
      for (int axis = 0; axis < 3; ++axis) {
        const auto at = static_cast<std::size_t>(axis);
        p[axis] = static_cast<float>(static_cast<double>(node.origin[at] + (std::int64_t{q[at]} << node.step_shift)) *
                                         step_m -
                                     scene.origin()[axis]);
      }
      points_.push_back(p);
    }
  }

  std::vector<gpu::TriangleLight> run() {
    const std::size_t count = mesh_.triangles.size();
    normals_.resize(count);
    areas_.resize(count);
    for (std::size_t t = 0; t < count; ++t) {
      const auto& [a, b, c] = mesh_.triangles[t];
      // From the lattice: in floats the area of a needle far from the origin may come out as none.
      const glm::dvec3 n = glm::cross(lattice(b) - lattice(a), lattice(c) - lattice(a));
      const double length = glm::length(n);
      normals_[t] = n / length;
      areas_[t] = static_cast<float>(length * step_m_ * step_m_);
    }
    group_corners();
    groups_.resize(sample_.size());
    for (std::size_t g = 0; g < groups_.size(); ++g) {
      const std::uint32_t corner = sample_[g];
      groups_[g] = receive(at(corner / 3, inset(corner % 3)), normals_[corner / 3]);
    }
    spread_bounce();
    std::vector<gpu::TriangleLight> light(count);
    bool needed = sun_.has_value();
    for (std::size_t t = 0; t < count; ++t) {
      light[t] = pack(t);
      needed = needed || (light[t].sky & 0xFFFFFFU) != 0xFFFFFFU;
    }
    if (!needed) light.clear();
    return light;
  }

 private:
  [[nodiscard]] glm::dvec3 lattice(std::uint32_t vertex) const {
    const auto& q = mesh_.vertices[vertex];
    return {q[0], q[1], q[2]};
  }
  static glm::vec3 inset(std::size_t k) {
    glm::vec3 b(kInset);
    b[static_cast<int>(k)] = 1 - 2 * kInset;
    return b;
  }
  [[nodiscard]] glm::vec3 at(std::size_t t, const glm::vec3& b) const {
    const auto& v = mesh_.triangles[t];
    return points_[v[0]] * b.x + points_[v[1]] * b.y + points_[v[2]] * b.z;
  }

  // Where rays start: on the outermost surface that the point stands for.
  [[nodiscard]] glm::vec3 start(const glm::vec3& p, const glm::vec3& normal) const {
    const float back = std::min(reach_m_, kSameSurfaceM);
    glm::vec3 from = p - normal * back;
    float left = back + reach_m_;
    glm::vec3 surface = p;
    for (int layer = 0; layer < 4 && left > 0; ++layer) {
      const auto hit = scene_.closest(from, normal, left);
      if (!hit) break;
      const glm::vec3 point = from + normal * hit->distance_m;
      const float above = glm::dot(point - p, normal);
      const bool aligned = std::abs(glm::dot(scene_.normal(hit->triangle), normal)) > 0.5F;
      // Leaving a body, or so near that it can be nothing else.
      if (aligned && above > 0 && (hit->from_behind || above <= kSameSurfaceM)) surface = point;
      from = point + normal * scene_.bias_m();
      left -= hit->distance_m + scene_.bias_m();
    }
    return surface + normal * scene_.bias_m();
  }

  [[nodiscard]] Received look_from(const glm::vec3& origin, const glm::vec3& normal, std::size_t& backs) const {
    Received got;
    const glm::mat3 frame = frame_of(normal);
    for (std::size_t first = 0; first < kRays; first += LightScene::kPacket) {
      std::array<glm::vec3, LightScene::kPacket> directions;
      for (std::size_t i = 0; i < directions.size(); ++i) directions[i] = frame * hemisphere()[first + i];
      for (const LightScene::Hit& hit : scene_.closest(origin, directions, kLightReachM)) {
        if (!std::isfinite(hit.distance_m)) {
          got.sky += 1.0F / kRays;
          continue;
        }
        backs += hit.from_behind ? 1 : 0;
        got.hidden += 1.0F / kRays;
        const glm::vec3& albedo = scene_.albedo(hit.triangle);
        got.around += albedo / float{kRays};
        for (std::size_t k = 0; k < kBounceSuns; ++k) got.sent[k] += albedo * (scene_.sunlight(hit, k) / kRays);
      }
    }
    return got;
  }

  // Surfaces may face the wrong way: a point that sees only the backs of others has its light on the other side.
  [[nodiscard]] Received receive(const glm::vec3& p, const glm::vec3& normal) const {
    std::size_t backs = 0;
    const Received front = look_from(start(p, normal), normal, backs);
    if (2 * backs < kRays) return front;
    std::size_t other_backs = 0;
    const Received back = look_from(start(p, -normal), -normal, other_backs);
    return back.sky > front.sky ? back : front;
  }

  // Corners at one point, on surfaces that face much the same way, are one; their largest triangle is sampled.
  void group_corners() {
    std::vector<std::uint32_t> order(3 * mesh_.triangles.size());
    std::iota(order.begin(), order.end(), 0U);
    const auto place = [&](std::uint32_t c) -> const auto& { return mesh_.vertices[mesh_.triangles[c / 3][c % 3]]; };
    std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
      if (place(a) != place(b)) return place(a) < place(b);
      return areas_[a / 3] != areas_[b / 3] ? areas_[a / 3] > areas_[b / 3] : a < b;
    });
    group_.resize(order.size());
    std::size_t first = 0;  // group at this point
    for (std::size_t i = 0; i < order.size(); ++i) {
      if (i == 0 || place(order[i]) != place(order[i - 1])) first = sample_.size();
      std::size_t g = first;
      while (g < sample_.size() && glm::dot(normals_[sample_[g] / 3], normals_[order[i] / 3]) < kSmoothCosine) ++g;
      if (g == sample_.size()) sample_.push_back(order[i]);
      group_[order[i]] = static_cast<std::uint32_t>(g);
    }
  }

  // Corners know the light at themselves; of large triangles it is what the light is all over them that counts, shared
  // among the corners by how near they are. A triangle has one bounced light for all of it: evened out along the
  // surface, so that no edge shows.
  void spread_bounce() {
    for (int round = 0; round < kBounceRounds; ++round) {
      std::vector<Received> next(groups_.size());
      std::vector<float> areas(groups_.size());
      std::vector<float> skies(groups_.size());
      for (std::size_t t = 0; t < mesh_.triangles.size(); ++t) {
        const std::array<std::uint32_t, 3> corner = {group_[3 * t], group_[3 * t + 1], group_[3 * t + 2]};
        std::array<float, 3> sky = {groups_[corner[0]].sky, groups_[corner[1]].sky, groups_[corner[2]].sky};
        const Received mean = round == 0 ? look_over(t, sky) : mean_of(t);
        for (std::size_t k = 0; k < 3; ++k) {
          next[corner[k]].add(mean, areas_[t]);
          areas[corner[k]] += areas_[t];
          skies[corner[k]] += sky[k] * areas_[t];
        }
      }
      for (std::size_t g = 0; g < groups_.size(); ++g) {
        next[g].scale(1 / areas[g]);
        next[g].sky = round == 0 ? skies[g] / areas[g] : groups_[g].sky;
      }
      groups_ = std::move(next);
    }
  }

  [[nodiscard]] Received mean_of(std::size_t t) const {
    Received mean;
    for (std::size_t k = 0; k < 3; ++k) mean.add(groups_[group_[3 * t + k]], 1.0F / 3);
    return mean;
  }

  [[nodiscard]] float longest_edge(std::size_t t) const {
    const auto& v = mesh_.triangles[t];
    return std::max({glm::distance(points_[v[0]], points_[v[1]]), glm::distance(points_[v[1]], points_[v[2]]),
                     glm::distance(points_[v[2]], points_[v[0]])});
  }

  // `sky`: at the corners, in and out.
  [[nodiscard]] Received look_over(std::size_t t, std::array<float, 3>& sky) const {
    const int rows = std::min(static_cast<int>(longest_edge(t) / kBounceSpacingM), kBounceMaxRows);
    if (rows == 0) return mean_of(t);
    Received mean;
    const float share = 2.0F / static_cast<float>(rows * (rows + 1));
    glm::vec3 skies(0);
    glm::vec3 weights(0);
    for (int i = 0; i < rows; ++i)
      for (int j = 0; i + j < rows; ++j) {
        const float a = (static_cast<float>(i) + 1.0F / 3) / static_cast<float>(rows);
        const float b = (static_cast<float>(j) + 1.0F / 3) / static_cast<float>(rows);
        const glm::vec3 at_point(a, b, 1 - a - b);
        const Received got = receive(at(t, at_point), normals_[t]);
        mean.add(got, share);
        skies += at_point * got.sky;
        weights += at_point;
      }
    for (std::size_t k = 0; k < 3; ++k) sky[k] = skies[static_cast<int>(k)] / weights[static_cast<int>(k)];
    return mean;
  }

  [[nodiscard]] gpu::TriangleLight pack(std::size_t t) const {
    gpu::TriangleLight light{};
    for (std::size_t k = 0; k < 3; ++k) light.sky |= quantised(groups_[group_[3 * t + k]].sky, 255) << (8 * k);
    const Received mean = mean_of(t);
    if (mean.hidden > 0) {
      // Colour of what is hit; how bright it is for each sun goes by its strongest channel.
      const glm::vec3 around = mean.around / mean.hidden;
      const float strongest = std::max({around.r, around.g, around.b, 1e-4F});
      glm::dvec4 fit(0);
      for (std::size_t k = 0; k < kBounceSuns; ++k) {
        const float sent = std::max({mean.sent[k].r, mean.sent[k].g, mean.sent[k].b});
        fit += fit_rows()[k] * static_cast<double>(sent / strongest);
      }
      const glm::vec3 slope(fit.y, fit.z, fit.w);
      const float varies = glm::length(slope);
      light.sky |= quantised(varies, 255) << 24U;
      light.bounce = quantised(around.b, 31) | quantised(around.g, 63) << 5U | quantised(around.r, 31) << 11U |
                     quantised(static_cast<float>(fit.x), 63) << 16U;
      if (varies > 0) light.bounce |= pack_direction(slope) << 24U;
    }
    if (sun_) light.bounce |= sun_state(t) << 22U;
    return light;
  }

  struct SunSeen {
    bool lit = false;
    bool shadow = false;
    bool unseen = false;

    [[nodiscard]] bool decided() const { return unseen || (lit && shadow); }
  };

  // Halves a triangle at its longest edge until that is shorter than the spacing, and traces from the middle of each
  // part; from the middles of the larger ones as well, for most that are partly lit show it there.
  void look_at_sun(const std::array<glm::vec3, 3>& p, const glm::vec3& normal, int halvings, SunSeen& seen) const {
    (scene_.blocked(start((p[0] + p[1] + p[2]) / 3.0F, normal), *sun_, kSunDistanceM) ? seen.shadow : seen.lit) = true;
    std::size_t longest = 0;  // the edge opposite to this corner
    float length = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      const float edge = glm::distance(p[(k + 1) % 3], p[(k + 2) % 3]);
      if (edge > length) std::tie(length, longest) = std::pair(edge, k);
    }
    if (length <= std::max(kSunSpacingM, 2 * reach_m_) || seen.decided()) return;
    if (halvings == kSunMaxHalvings) {
      seen.unseen = true;
      return;
    }
    const glm::vec3 middle = (p[(longest + 1) % 3] + p[(longest + 2) % 3]) * 0.5F;
    for (std::size_t k = 1; k < 3 && !seen.decided(); ++k) {
      std::array<glm::vec3, 3> half = p;
      half[(longest + k) % 3] = middle;
      look_at_sun(half, normal, halvings + 1, seen);
    }
  }

  [[nodiscard]] std::uint32_t sun_state(std::size_t t) const {
    const float cosine = glm::dot(normals_[t], *sun_);
    const glm::vec3 normal = cosine < 0 ? -normals_[t] : normals_[t];
    const auto& v = mesh_.triangles[t];
    SunSeen seen;
    look_at_sun({points_[v[0]], points_[v[1]], points_[v[2]]}, normal, 0, seen);
    if (seen.decided()) return gpu::kSunUnknown;
    return seen.lit ? gpu::kSunLit : gpu::kSunShadow;
  }

  const ZoneMesh& mesh_;
  const LightScene& scene_;
  double step_m_;  // of the zone
  std::optional<glm::vec3> sun_;
  float reach_m_ = 0;  // how far the city's surface may be
  std::vector<glm::vec3> points_;
  std::vector<glm::vec3> normals_;
  std::vector<float> areas_;
  std::vector<std::uint32_t> group_;   // per corner
  std::vector<std::uint32_t> sample_;  // per group: the corner that stands for it
  std::vector<Received> groups_;
};

}  // namespace

glm::vec3 sun_direction(const SunAngles& sun) {
  const double azimuth = sun.azimuth_deg * 3.14159265358979 / 180;
  const double elevation = sun.elevation_deg * 3.14159265358979 / 180;
  return glm::vec3(std::sin(azimuth) * std::cos(elevation), std::cos(azimuth) * std::cos(elevation),
                   std::sin(elevation));
}

std::vector<gpu::TriangleLight> bake_zone_light(const ZoneMesh& mesh, const NodeRecord& node, const LightScene& scene,
                                                const std::optional<SunAngles>& sun, double step_m) {
  std::vector<gpu::TriangleLight> light = ZoneLight(mesh, node, scene, sun, step_m).run();
  quantise_light(mesh, light);
  return light;
}

}  // namespace zc
