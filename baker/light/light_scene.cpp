// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/light/light_scene.h"

#include <embree3/rtcore.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <string>

#include "baker/light/light_threads.h"

namespace zc {
namespace {

constexpr float kMinBiasM = 2e-3F;
// Roundings of a coordinate that a ray's start must clear.
constexpr float kBiasUlps = 8;
constexpr float kSunDistanceM = 1e6F;
// Points of a triangle that the sun is looked for from.
constexpr std::array<glm::vec3, 4> kSunPoints = {
    {{1.0F / 3, 1.0F / 3, 1.0F / 3}, {0.7F, 0.15F, 0.15F}, {0.15F, 0.7F, 0.15F}, {0.15F, 0.15F, 0.7F}}};

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

struct LightScene::Handles {
  RTCDevice device = nullptr;
  RTCScene scene = nullptr;

  Handles() = default;
  Handles(const Handles&) = delete;
  Handles& operator=(const Handles&) = delete;
  ~Handles() {
    if (scene != nullptr) rtcReleaseScene(scene);
    if (device != nullptr) rtcReleaseDevice(device);
  }
};

LightScene::LightScene() : handles_(std::make_unique<Handles>()) {}
LightScene::LightScene(LightScene&&) noexcept = default;
LightScene::~LightScene() = default;

Result<LightScene> LightScene::build(std::span<const ZoneMesh> meshes, std::span<const NodeRecord> nodes,
                                     std::span<const Material> materials, double step_m, unsigned threads) {
  LightScene out;
  float extent = 1;
  std::size_t triangles = 0;
  for (const NodeRecord& node : nodes) triangles += node.is_detail() ? node.triangle_count : 0;
  out.vertices_.reserve(3 * triangles + 1);  // Embree loads 16 bytes at the last vertex
  for (std::size_t n = 0; n < nodes.size(); ++n) {
    if (!nodes[n].is_detail()) continue;
    const ZoneMesh& mesh = meshes[n];
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
      for (const std::uint32_t v : mesh.triangles[t]) {
        glm::vec3 p;
        for (int axis = 0; axis < 3; ++axis) {
          const auto at = static_cast<std::size_t>(axis);
          const std::int64_t lattice =
              nodes[n].origin[at] + (std::int64_t{mesh.vertices[v][at]} << nodes[n].step_shift);
          p[axis] = static_cast<float>(static_cast<double>(lattice) * step_m);
          extent = std::max(extent, std::abs(p[axis]));
        }
        out.vertices_.push_back(p);
      }
      const glm::vec3* corner = &out.vertices_[out.vertices_.size() - 3];
      out.normal_.push_back(glm::normalize(glm::cross(corner[1] - corner[0], corner[2] - corner[0])));
      out.albedo_.push_back(materials[mesh.materials[t]].base_color);
    }
  }
  out.bias_m_ = std::max(kMinBiasM, kBiasUlps * extent * std::numeric_limits<float>::epsilon());

  RTCDevice device = rtcNewDevice("threads=1,isa=avx2,max_isa=avx2");
  if (device == nullptr) device = rtcNewDevice("threads=1");  // a processor without AVX2
  out.handles_->device = device;
  if (device == nullptr) return Error{ErrorCode::kDevice, "Embree cannot be started"};
  out.handles_->scene = rtcNewScene(device);
  rtcSetSceneFlags(out.handles_->scene, RTC_SCENE_FLAG_ROBUST);
  const RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
  const std::size_t count = out.normal_.size();
  rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, out.vertices_.data(), 0,
                             sizeof(glm::vec3), out.vertices_.size());
  auto* indices = static_cast<std::uint32_t*>(
      rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 3 * sizeof(std::uint32_t), count));
  if (indices != nullptr)
    for (std::uint32_t i = 0; i < 3 * count; ++i) indices[i] = i;
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(out.handles_->scene, geometry);
  rtcReleaseGeometry(geometry);
  rtcCommitScene(out.handles_->scene);
  if (const RTCError error = rtcGetDeviceError(device); error != RTC_ERROR_NONE || indices == nullptr)
    return Error{error == RTC_ERROR_OUT_OF_MEMORY ? ErrorCode::kBudget : ErrorCode::kDevice,
                 "Embree failed with error " + std::to_string(error)};
  out.measure_sunlight(threads);
  return out;
}

void LightScene::measure_sunlight(unsigned threads) {
  sunlight_.resize(normal_.size());
  for_each_on_threads(sunlight_.size(), threads, [&](std::size_t t) {
    const glm::vec3* corner = &vertices_[3 * t];
    for (std::size_t k = 0; k < kBounceSuns; ++k) {
      const glm::vec3& sun = bounce_suns()[k];
      const float cosine = glm::dot(normal_[t], sun);
      int lit = 0;
      for (const glm::vec3& b : kSunPoints) {
        const glm::vec3 p = corner[0] * b.x + corner[1] * b.y + corner[2] * b.z;
        lit += blocked(p + normal_[t] * std::copysign(bias_m_, cosine), sun, kSunDistanceM) ? 0 : 1;
      }
      const float share = cosine * static_cast<float>(lit) / static_cast<float>(kSunPoints.size());
      sunlight_[t][k] = static_cast<std::int8_t>(std::lround(share * 127));
    }
  });
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
  return Hit{query.ray.tfar, query.hit.primID, glm::dot(normal_[query.hit.primID], direction) > 0};
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
    const std::uint32_t triangle = query.hit.primID[i];
    hits[i] = {query.ray.tfar[i], triangle, glm::dot(normal_[triangle], directions[i]) > 0};
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
  const auto share = static_cast<float>(sunlight_[hit.triangle][k]) / 127;
  return std::max(hit.from_behind ? -share : share, 0.0F);
}

}  // namespace zc
