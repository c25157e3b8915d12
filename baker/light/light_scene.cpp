// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/light/light_scene.h"

#include <embree3/rtcore.h>

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <limits>
#include <numeric>
#include <string>
#include <utility>

#include "baker/distance/triangle_pieces.h"
#include "baker/light/light_threads.h"

namespace zc {
namespace {

constexpr float kMinBiasM = 2e-3F;
// Roundings of a coordinate that a ray's start must clear.
constexpr float kBiasUlps = 8;
constexpr float kSunDistanceM = 1e6F;
// Points of a triangle that rays to the sun start from.
constexpr std::array<glm::vec3, 4> kSunPoints = {
    {{1.0F / 3, 1.0F / 3, 1.0F / 3}, {0.7F, 0.15F, 0.15F}, {0.15F, 0.7F, 0.15F}, {0.15F, 0.15F, 0.7F}}};

constexpr double kPieceStepM = 1.0 / 256;
constexpr double kWasteLimit = 30;  // times the surface of the scene's box; cities come to less than a tenth of it
constexpr std::size_t kMorePieces = 1U << 19U;

RTCRay make_ray(const glm::vec3& origin, const glm::vec3& direction, float far_m) {
  RTCRay ray{};
  ray.org_x = origin.x;
  ray.org_y = origin.y;
  ray.org_z = origin.z;
  ray.dir_x = direction.x;
  ray.dir_y = direction.y;
  ray.dir_z = direction.z;
  ray.tfar = far_m;
  ray.mask = ~0U;
  return ray;
}

}  // namespace

const std::array<glm::vec3, kBounceSuns>& bounce_suns() {
  static const std::array<glm::vec3, kBounceSuns> suns = [] {
    std::array<glm::vec3, kBounceSuns> out{};
    out[0] = {0, 0, 1};
    for (std::size_t i = 1; i < kBounceSuns; ++i) {  // 40 degrees high, round the compass
      const double turn = static_cast<double>(i - 1) * 2 * 3.14159265358979 / (kBounceSuns - 1);
      out[i] = glm::vec3(std::sin(turn) * 0.7660444431, std::cos(turn) * 0.7660444431, 0.6427876097);
    }
    return out;
  }();
  return suns;
}

LightDetail::LightDetail(std::span<const ZoneMesh> meshes, std::span<const NodeRecord> nodes,
                         std::span<const Material> materials, double step_m) {
  std::size_t triangles = 0;
  for (const NodeRecord& node : nodes) {
    triangles += node.is_detail() ? node.triangle_count : 0;
    for (std::size_t axis = 0; axis < 3; ++axis) is_wide_ = is_wide_ || node.bounds_max[axis] * step_m > kWideWorldM;
  }
  corners.reserve(3 * triangles + 1);  // Embree loads 16 bytes at the last corner
  for (std::size_t n = 0; n < nodes.size(); ++n) {
    if (!nodes[n].is_detail()) continue;
    const ZoneMesh& mesh = meshes[n];
    Part part;
    part.node = static_cast<std::uint32_t>(n);
    part.first = static_cast<std::uint32_t>(normal.size());
    parts.push_back(part);
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
      std::array<glm::dvec3, 3> triangle{};
      for (std::size_t k = 0; k < 3; ++k)
        for (std::size_t axis = 0; axis < 3; ++axis) {
          const std::int64_t offset = std::int64_t{mesh.vertices[mesh.triangles[t][k]][axis]} << nodes[n].step_shift;
          triangle[k][static_cast<int>(axis)] = static_cast<double>(nodes[n].origin[axis] + offset) * step_m;
        }
      add(triangle);
      albedo.push_back(materials[mesh.materials[t]].base_color);
    }
  }
  finish();
}

LightDetail::LightDetail(const LatticeMesh& mesh, double step_m) {
  corners.reserve(3 * mesh.faces.size() + 1);
  parts.emplace_back();
  for (const LatticeFace& face : mesh.faces) {
    std::array<glm::dvec3, 3> triangle{};
    for (std::size_t k = 0; k < 3; ++k) triangle[k] = to_dvec(mesh.vertices[face.v[k]]) * step_m;
    add(triangle);
  }
  finish();
}

void LightDetail::add(const std::array<glm::dvec3, 3>& triangle) {
  Part& part = parts.back();
  const std::array<glm::vec3, 3> rounded = {triangle[0], triangle[1], triangle[2]};
  if (part.count++ == 0) part.low = part.high = rounded[0];
  for (std::size_t k = 0; k < 3; ++k) {
    part.low = glm::min(part.low, rounded[k]);
    part.high = glm::max(part.high, rounded[k]);
    corners.push_back(rounded[k]);
    if (is_wide_) exact.push_back(triangle[k]);
  }
  const glm::vec3 of_rounded = glm::cross(rounded[1] - rounded[0], rounded[2] - rounded[0]);
  if (!is_wide_ && of_rounded != glm::vec3(0)) {
    normal.push_back(glm::normalize(of_rounded));
    return;
  }
  const glm::dvec3 n = glm::cross(triangle[1] - triangle[0], triangle[2] - triangle[0]);
  normal.push_back(n == glm::dvec3(0) ? glm::vec3(0, 0, 1) : glm::vec3(glm::normalize(n)));
}

void LightDetail::finish() {
  float extent = 1;
  for (const glm::vec3& p : corners) {
    const glm::vec3 far = glm::abs(p);
    extent = std::max({extent, far.x, far.y, far.z});
  }
  sunlight.resize(normal.size());
  bias_m = std::max(kMinBiasM, kBiasUlps * extent * std::numeric_limits<float>::epsilon());
}

LightFrame LightFrame::around(const LightDetail& detail, const glm::vec3& low, const glm::vec3& high) {
  if (detail.exact.empty()) return {glm::dvec3(0), detail.bias_m};
  const glm::dvec3 half = (glm::dvec3(high) - glm::dvec3(low)) * 0.5;
  const auto extent = static_cast<float>(std::max({half.x, half.y, half.z}));
  // Whole metres, so that nothing else is rounded.
  return {glm::round(glm::dvec3(low) + half),
          std::max(kMinBiasM, kBiasUlps * extent * std::numeric_limits<float>::epsilon())};
}

Result<LightDevice> LightDevice::create() {
  RTCDevice device = rtcNewDevice("threads=1,isa=avx2,max_isa=avx2");
  if (device == nullptr) device = rtcNewDevice("threads=1");  // a processor without AVX2
  if (device == nullptr) return Error{ErrorCode::kDevice, "Embree cannot be started"};
  return LightDevice(device);
}
LightDevice::LightDevice(LightDevice&& other) noexcept : device_(std::exchange(other.device_, nullptr)) {}
LightDevice::~LightDevice() {
  if (device_ != nullptr) rtcReleaseDevice(device_);
}

struct LightScene::Handles {
  RTCScene scene = nullptr;

  explicit Handles(RTCDevice device) : scene(rtcNewScene(device)) {}
  Handles(const Handles&) = delete;
  Handles& operator=(const Handles&) = delete;
  ~Handles() { rtcReleaseScene(scene); }
};

LightScene::LightScene(const LightDetail& detail, const LightFrame& frame) : detail_(&detail), frame_(frame) {}
LightScene::LightScene(LightScene&&) noexcept = default;
LightScene::~LightScene() = default;

Result<LightScene> LightScene::build(const LightDevice& device, const LightDetail& detail,
                                     std::span<const std::uint32_t> parts, const LightFrame& frame) {
  LightScene out(detail, frame);
  for (const std::uint32_t p : parts) {
    const LightDetail::Part& part = detail.parts[p];
    for (std::uint32_t i = 0; i < part.count; ++i) out.triangles_.push_back(part.first + i);
  }
  out.handles_ = std::make_unique<Handles>(device.handle());
  rtcSetSceneFlags(out.handles_->scene, RTC_SCENE_FLAG_ROBUST);
  out.cut_wasteful();
  if (out.own_corners_.empty() && !detail.exact.empty()) {
    out.own_corners_.reserve(3 * out.triangles_.size() + 1);  // Embree loads 16 bytes at the last corner
    for (const std::uint32_t t : out.triangles_)
      for (const glm::vec3& p : out.corners_of(t)) out.own_corners_.push_back(p);
  }
  const bool is_own = !out.own_corners_.empty();
  const std::vector<glm::vec3>& corners = is_own ? out.own_corners_ : detail.corners;
  const RTCGeometry geometry = rtcNewGeometry(device.handle(), RTC_GEOMETRY_TYPE_TRIANGLE);
  rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, corners.data(), 0,
                             sizeof(glm::vec3), corners.size());
  auto* indices = static_cast<std::uint32_t*>(rtcSetNewGeometryBuffer(
      geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 3 * sizeof(std::uint32_t), out.triangles_.size()));
  if (indices != nullptr)
    for (std::uint32_t i = 0; i < out.triangles_.size(); ++i)
      for (std::uint32_t k = 0; k < 3; ++k) *indices++ = 3 * (is_own ? i : out.triangles_[i]) + k;
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(out.handles_->scene, geometry);
  rtcReleaseGeometry(geometry);
  rtcCommitScene(out.handles_->scene);
  if (const RTCError error = rtcGetDeviceError(device.handle()); error != RTC_ERROR_NONE || indices == nullptr)
    return Error{error == RTC_ERROR_OUT_OF_MEMORY ? ErrorCode::kBudget : ErrorCode::kDevice,
                 "Embree failed with error " + std::to_string(error)};
  return out;
}

Result<LightScene> LightScene::build(std::span<const ZoneMesh> meshes, std::span<const NodeRecord> nodes,
                                     std::span<const Material> materials, double step_m, unsigned threads) {
  ZC_ASSIGN(LightDevice device, LightDevice::create());
  auto detail = std::make_unique<LightDetail>(meshes, nodes, materials, step_m);
  std::vector<std::uint32_t> parts(detail->parts.size());
  std::iota(parts.begin(), parts.end(), 0U);
  ZC_ASSIGN(LightScene out, build(device, *detail, parts, {glm::dvec3(0), detail->bias_m}));
  for_each_on_threads(detail->sunlight.size(), threads, [&](std::size_t t) {
    detail->sunlight[t] = out.measure_sunlight(static_cast<std::uint32_t>(t));
  });
  out.own_device_ = std::make_unique<LightDevice>(std::move(device));
  out.own_detail_ = std::move(detail);
  return out;
}

std::array<glm::vec3, 3> LightScene::corners_of(std::uint32_t triangle) const {
  std::array<glm::vec3, 3> out{};
  for (std::size_t k = 0; k < 3; ++k) {
    const std::size_t i = 3 * std::size_t{triangle} + k;
    out[k] = detail_->exact.empty() ? detail_->corners[i] : glm::vec3(detail_->exact[i] - frame_.origin);
  }
  return out;
}

void LightScene::cut_wasteful() {
  const auto piece_of = [&](std::size_t i) {
    const std::array<glm::vec3, 3> corner = corners_of(triangles_[i]);
    Corners corners;
    for (std::size_t k = 0; k < 3; ++k) corners[k] = glm::dvec3(corner[k]) / kPieceStepM;
    return corners;
  };
  const std::size_t count = triangles_.size();
  LatticeBox bounds;
  double waste = 0;
  for (std::uint32_t i = 0; i < count; ++i) {
    const TrianglePiece whole(piece_of(i), i);
    bounds.add(whole.box);
    waste += whole.waste;
  }
  if (waste <= kWasteLimit * half_surface(bounds)) return;
  const std::vector<TrianglePiece> pieces =
      pieces_of(count, piece_of, half_surface(bounds) / static_cast<double>(count), count + kMorePieces);
  std::vector<std::uint32_t> whole = std::move(triangles_);
  triangles_.clear();
  own_corners_.reserve(3 * pieces.size() + 1);  // Embree loads 16 bytes at the last corner
  for (const TrianglePiece& piece : pieces) {
    triangles_.push_back(whole[piece.triangle]);
    for (const glm::dvec3& p : piece.corner) own_corners_.emplace_back(p * kPieceStepM);
  }
}

LightDetail::Sunlight LightScene::measure_sunlight(std::uint32_t triangle) const {
  LightDetail::Sunlight out{};
  const std::array<glm::vec3, 3> corner = corners_of(triangle);
  const glm::vec3& normal = detail_->normal[triangle];
  for (std::size_t k = 0; k < kBounceSuns; ++k) {
    const glm::vec3& sun = bounce_suns()[k];
    const float cosine = glm::dot(normal, sun);
    int lit = 0;
    for (const glm::vec3& b : kSunPoints) {
      const glm::vec3 p = corner[0] * b.x + corner[1] * b.y + corner[2] * b.z;
      lit += blocked(p + normal * std::copysign(bias_m(), cosine), sun, kSunDistanceM) ? 0 : 1;
    }
    const float share = cosine * static_cast<float>(lit) / static_cast<float>(kSunPoints.size());
    out[k] = static_cast<std::int8_t>(std::lround(share * 127));
  }
  return out;
}

LightScene::Hit LightScene::hit(unsigned primitive, float distance_m, const glm::vec3& direction) const {
  const std::uint32_t triangle = triangles_[primitive];
  return {distance_m, triangle, glm::dot(normal(triangle), direction) > 0};
}

std::optional<LightScene::Hit> LightScene::closest(const glm::vec3& origin, const glm::vec3& direction,
                                                   float far_m) const {
  RTCRayHit query{};
  query.ray = make_ray(origin, direction, far_m);
  query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcIntersect1(handles_->scene, &context, &query);
  if (query.hit.geomID == RTC_INVALID_GEOMETRY_ID) return std::nullopt;
  return hit(query.hit.primID, query.ray.tfar, direction);
}

std::array<LightScene::Hit, LightScene::kPacket> LightScene::closest(const glm::vec3& origin,
                                                                     std::span<const glm::vec3, kPacket> directions,
                                                                     float far_m) const {
  RTCRayHit8 query{};
  alignas(32) std::array<int, kPacket> valid{};
  for (std::size_t i = 0; i < kPacket; ++i) {
    query.ray.org_x[i] = origin.x;
    query.ray.org_y[i] = origin.y;
    query.ray.org_z[i] = origin.z;
    query.ray.dir_x[i] = directions[i].x;
    query.ray.dir_y[i] = directions[i].y;
    query.ray.dir_z[i] = directions[i].z;
    query.ray.tfar[i] = far_m;
    query.ray.mask[i] = ~0U;
    query.hit.geomID[i] = RTC_INVALID_GEOMETRY_ID;
    valid[i] = -1;
  }
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcIntersect8(valid.data(), handles_->scene, &context, &query);
  std::array<Hit, kPacket> hits;
  for (std::size_t i = 0; i < kPacket; ++i) {
    hits[i].distance_m = std::numeric_limits<float>::infinity();
    if (query.hit.geomID[i] == RTC_INVALID_GEOMETRY_ID) continue;
    hits[i] = hit(query.hit.primID[i], query.ray.tfar[i], directions[i]);
  }
  return hits;
}

bool LightScene::blocked(const glm::vec3& origin, const glm::vec3& direction, float far_m) const {
  RTCRay ray = make_ray(origin, direction, far_m);
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcOccluded1(handles_->scene, &context, &ray);
  return ray.tfar < 0;
}

float LightScene::sunlight(const Hit& hit, std::size_t k) const {
  const auto share = static_cast<float>(detail_->sunlight[hit.triangle][k]) / 127;
  return std::max(hit.from_behind ? -share : share, 0.0F);
}

}  // namespace zc
