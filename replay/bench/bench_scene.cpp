// SPDX-License-Identifier: Apache-2.0
#include "replay/bench/bench_scene.h"

#include <bit>
#include <cmath>
#include <cstring>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>
#include <set>
#include <utility>

#include "base/check.h"
#include "base/file.h"
#include "streamer/open_source.h"
#include "streamer/paging/page_loader.h"
#include "streamer/source/index_file.h"
#include "streamer/source/source.h"
#include "streamer/world_format/page_view.h"

namespace zc::bench {
namespace {

constexpr std::uint64_t kLargestRawFile = 4ULL << 30U;
constexpr float kLargestValue = 1.8e18F;
constexpr std::int64_t kExactSteps = 1 << 24;
constexpr double kOffsetSteps = 4;  // of a mirror ray's origin, off its surface

// The triangles of a page, each once: spatial splits keep copies.
std::vector<PageView::Triangle> page_triangles(std::span<const std::uint32_t> page) {
  const PageView view(page);
  const bool split = (view.header().flags & gpu::kPageSplitTriangles) != 0;
  std::vector<PageView::Triangle> triangles;
  std::set<std::array<PageView::Point, 3>> seen;
  for (std::uint32_t i = 0; i < view.header().triangle_count; ++i) {
    const PageView::Triangle triangle = view.triangle(i);
    if (!split || seen.insert(triangle.corners).second) triangles.push_back(triangle);
  }
  return triangles;
}

}  // namespace

SceneAssembly::SceneAssembly(std::string name, const CrsPoint& origin, double step_m) {
  scene_.name = std::move(name);
  scene_.origin = origin;
  scene_.step_m = step_m;
}

void SceneAssembly::begin_zone(std::uint32_t step_shift) {
  if (!scene_.zones.empty() && scene_.zones.back().count == 0) scene_.zones.pop_back();
  scene_.zones.push_back({static_cast<std::uint32_t>(scene_.triangles.size()), 0, step_shift});
}

Status SceneAssembly::add(const std::array<CrsPoint, 3>& corners) {
  ZC_CHECK(!scene_.zones.empty());
  BenchTriangle triangle;
  for (std::size_t i = 0; i < 9; ++i) {
    const std::int64_t steps = corners[i / 3][i % 3] - scene_.origin[i % 3];
    if (steps <= -kExactSteps || steps >= kExactSteps)
      return Error{ErrorCode::kUnsupported, "a triangle lies " + std::to_string(std::abs(steps)) +
                                                " lattice steps from the local origin, where floats are not exact"};
    triangle.v[i] = static_cast<float>(static_cast<double>(steps) * scene_.step_m);
  }
  scene_.triangles.push_back(triangle);
  ++scene_.zones.back().count;
  return {};
}

Result<BenchScene> SceneAssembly::finish() && {
  if (scene_.triangles.empty()) return Error{ErrorCode::kFormat, "no triangle is left to trace"};
  if (scene_.zones.back().count == 0) scene_.zones.pop_back();
  return std::move(scene_);
}

Result<CrsPoint> lattice_point(const glm::dvec3& position_m, double step_m) {
  CrsPoint point;
  for (int axis = 0; axis < 3; ++axis) {
    if (!(std::abs(position_m[axis]) <= 1e12))
      return Error{ErrorCode::kUnsupported, "a position of " + std::to_string(position_m[axis]) + " m"};
    point[static_cast<std::size_t>(axis)] = std::llround(position_m[axis] / step_m);
  }
  return point;
}

Result<BenchScene> load_world_scene(const std::filesystem::path& world, const WorldSceneOptions& options) {
  ZC_ASSIGN(const std::unique_ptr<Source> source, open_source(world, options.source));
  ZC_ASSIGN(const WorldIndex index, read_world_index(*source, world));
  CrsPoint anchor = index.header.anchor;
  for (std::size_t axis = 0; axis < 3; ++axis) anchor[axis] += options.offset_steps[axis];
  CrsPoint origin = anchor;
  if (options.camera != nullptr) {
    ZC_ASSIGN(origin, lattice_point(options.camera->eye, index.step_m()));
  }
  const auto folder = world.has_filename() ? world : world.parent_path();
  SceneAssembly assembly(folder.filename().string(), origin, index.step_m());
  for (std::uint32_t id = 0; id < index.nodes.size(); ++id) {
    const NodeRecord& node = index.nodes[id];
    if (!node.is_detail()) continue;
    ZC_ASSIGN(const std::vector<std::uint32_t> page, load_page(*source, index, id));
    assembly.begin_zone(node.step_shift);
    for (const PageView::Triangle& triangle : page_triangles(page)) {
      std::array<CrsPoint, 3> corners;
      for (std::size_t i = 0; i < 9; ++i) {
        const std::size_t axis = i % 3;
        corners[i / 3][axis] = anchor[axis] + triangle.corners[i / 3][axis];
      }
      ZC_TRY(assembly.add(corners));
    }
  }
  Result<BenchScene> scene = std::move(assembly).finish();
  if (!scene) return Error{scene.error().code, scene.error().message, world.string()};
  return scene;
}

Result<RawRecords> read_raw_records(const std::filesystem::path& file, std::size_t width) {
  static_assert(std::endian::native == std::endian::little);
  const std::size_t record_bytes = width * sizeof(float);
  ZC_ASSIGN(const std::uint64_t bytes, file_size_bytes(file));
  if (bytes % record_bytes != 0)
    return Error{ErrorCode::kFormat,
                 "its " + std::to_string(bytes) + " bytes are no multiple of " + std::to_string(record_bytes) + " (" +
                     std::to_string(width) + " floats a record)",
                 file.string()};
  ZC_ASSIGN(const std::vector<std::byte> data, read_file(file, kLargestRawFile));
  RawRecords records;
  records.values.reserve(data.size() / sizeof(float));
  std::vector<float> record(width);
  for (std::size_t at = 0; at + record_bytes <= data.size(); at += record_bytes) {
    std::memcpy(record.data(), data.data() + at, record_bytes);
    bool good = true;
    for (const float v : record) good = good && std::abs(v) <= kLargestValue;  // false for NaN
    if (good) {
      records.values.insert(records.values.end(), record.begin(), record.end());
    } else {
      ++records.dropped;
    }
  }
  return records;
}

Result<RaySet> read_rays(const std::filesystem::path& file, const glm::dvec3& origin_m) {
  ZC_ASSIGN(const RawRecords records, read_raw_records(file, 6));
  RaySet set;
  set.dropped = records.dropped;
  set.rays.reserve(records.values.size() / 6);
  for (std::size_t at = 0; at < records.values.size(); at += 6) {
    const float* v = records.values.data() + at;
    const glm::dvec3 origin = glm::dvec3(v[0], v[1], v[2]) - origin_m;
    const glm::dvec3 direction(v[3], v[4], v[5]);
    const double length = glm::length(direction);
    if (length == 0)
      return Error{ErrorCode::kFormat,
                   "ray " + std::to_string(at / 6) + " has a direction of zero" +
                       (set.dropped == 0 ? "" : ", counted without the " + std::to_string(set.dropped) + " dropped"),
                   file.string()};
    const glm::vec3 o(origin);
    const glm::vec3 d(direction / length);
    set.rays.push_back({o.x, o.y, o.z, d.x, d.y, d.z});
  }
  if (set.rays.empty())
    return Error{ErrorCode::kFormat,
                 std::string("holds no ray") + (set.dropped == 0 ? "" : " of numbers within 1.8e18"), file.string()};
  return set;
}

Result<std::vector<BenchRay>> make_mirror_rays(const Oracle& oracle, const BenchScene& scene,
                                               const CameraSample& camera, const MirrorView& view) {
  glm::dvec3 eye;
  for (int axis = 0; axis < 3; ++axis) {
    const auto i = static_cast<std::size_t>(axis);
    eye[axis] = (camera.eye[axis] / scene.step_m - static_cast<double>(scene.origin[i])) * scene.step_m;
  }
  const glm::dvec3 forward = glm::normalize(camera.target - camera.eye);
  const glm::dvec3 roughly_up = std::abs(forward.z) > 0.9999 ? glm::dvec3(0, 1, 0) : glm::dvec3(0, 0, 1);
  const glm::dvec3 right = glm::normalize(glm::cross(forward, roughly_up));
  const glm::dvec3 up = glm::cross(right, forward);
  const double half_height = std::tan(glm::radians(camera.fov_y_deg) / 2);
  const double half_width = half_height * view.width / view.height;

  std::vector<std::array<std::uint32_t, 2>> pixels;
  pixels.reserve(std::size_t{view.width} * view.height);
  const std::uint32_t side = view.order == PixelOrder::kTiles ? 8 : 1;
  for (std::uint32_t y = 0; y < view.height; y += side)
    for (std::uint32_t x = 0; x < view.width; x += side)
      for (std::uint32_t i = 0; i < side * side; ++i)
        if (x + i % side < view.width && y + i / side < view.height) pixels.push_back({x + i % side, y + i / side});

  const glm::vec3 start(eye);
  std::vector<BenchRay> primary;
  primary.reserve(pixels.size());
  for (const auto& [x, y] : pixels) {
    const glm::vec3 d(glm::normalize(forward + right * (half_width * ((x + 0.5) / view.width * 2 - 1)) +
                                     up * (half_height * (1 - (y + 0.5) / view.height * 2))));
    primary.push_back({start.x, start.y, start.z, d.x, d.y, d.z});
  }
  const std::vector<OracleHit> hits = oracle.trace(primary, view.threads);
  std::vector<BenchRay> mirrored;
  mirrored.reserve(primary.size());
  for (std::size_t i = 0; i < primary.size(); ++i) {
    if (hits[i].triangle == kMiss) continue;
    const auto corners = oracle.corners(hits[i].triangle);
    const glm::dvec3 d(primary[i].dx, primary[i].dy, primary[i].dz);
    glm::dvec3 n = glm::normalize(glm::cross(corners[1] - corners[0], corners[2] - corners[0]));
    if (glm::dot(n, d) > 0) n = -n;
    const glm::vec3 o(glm::dvec3(start) + hits[i].t * d + n * (kOffsetSteps * scene.step_m));
    const glm::vec3 r(glm::normalize(d - 2 * glm::dot(d, n) * n));
    mirrored.push_back({o.x, o.y, o.z, r.x, r.y, r.z});
  }
  if (mirrored.empty())
    return Error{ErrorCode::kUnsupported, "the camera sees no surface: do path and scene share a CRS?"};
  return mirrored;
}

}  // namespace zc::bench
