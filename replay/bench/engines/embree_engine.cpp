// SPDX-License-Identifier: Apache-2.0
#include "replay/bench/engines/embree_engine.h"

#ifdef ZONECAST_EMBREE
#include <embree3/rtcore.h>

#include <atomic>
#include <map>

#include "replay/bench/engines/parallel_chunks.h"
#include "replay/bench/engines/stopwatch.h"

namespace zc::bench {
namespace {

class EmbreeEngine final : public TraceEngine {
 public:
  EmbreeEngine(bool robust, bool any_hit, unsigned threads) : robust_(robust), any_hit_(any_hit), threads_(threads) {}
  ~EmbreeEngine() override {
    if (scene_ != nullptr) rtcReleaseScene(scene_);
    if (device_ != nullptr) rtcReleaseDevice(device_);
  }

  [[nodiscard]] std::string name() const override { return robust_ ? "embree_robust" : "embree"; }
  [[nodiscard]] BuildFigures figures() const override { return figures_; }

  Status build(const BenchScene& scene) override {
    weld(scene.triangles);
    const std::string config = "threads=" + std::to_string(threads_);
    device_ = rtcNewDevice(config.c_str());
    if (device_ == nullptr) return fault("rtcNewDevice");
    rtcSetDeviceMemoryMonitorFunction(device_, &EmbreeEngine::on_memory, this);
    const Stopwatch watch;
    scene_ = rtcNewScene(device_);
    rtcSetSceneFlags(scene_, robust_ ? RTC_SCENE_FLAG_ROBUST : RTC_SCENE_FLAG_NONE);
    rtcSetSceneBuildQuality(scene_, RTC_BUILD_QUALITY_HIGH);
    RTCGeometry geometry = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_TRIANGLE);
    rtcSetGeometryBuildQuality(geometry, RTC_BUILD_QUALITY_HIGH);
    // Embree may read 16 bytes at the last vertex: weld() left room for that.
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, vertices_.data(), 0, 12,
                               vertices_.size() / 3 - 1);
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, indices_.data(), 0, 12,
                               indices_.size() / 3);
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene_, geometry);
    rtcReleaseGeometry(geometry);
    rtcCommitScene(scene_);
    figures_.build_ms = watch.ms();
    const auto embree_bytes = static_cast<std::uint64_t>(bytes_.load());
    figures_.bytes = embree_bytes + vertices_.size() * sizeof(float) + indices_.size() * sizeof(std::uint32_t);
    return fault("rtcCommitScene");
  }

  Result<double> trace(std::span<const BenchRay> rays, std::span<BenchHit> hits) override {
    const Stopwatch watch;
    parallel_chunks(rays.size(), threads_, [&](std::size_t begin, std::size_t end) {
      RTCIntersectContext context;
      rtcInitIntersectContext(&context);
      for (std::size_t i = begin; i < end; ++i)
        hits[i] = any_hit_ ? occluded(context, rays[i]) : nearest(context, rays[i]);
    });
    const double ms = watch.ms();
    ZC_TRY(fault(any_hit_ ? "rtcOccluded1" : "rtcIntersect1"));
    return ms;
  }

 private:
  static RTCRay to_ray(const BenchRay& from) {
    RTCRay ray{};
    ray.org_x = from.ox, ray.org_y = from.oy, ray.org_z = from.oz;
    ray.dir_x = from.dx, ray.dir_y = from.dy, ray.dir_z = from.dz;
    ray.tfar = std::numeric_limits<float>::infinity();
    ray.mask = 0xFFFFFFFFU;
    return ray;
  }
  BenchHit nearest(RTCIntersectContext& context, const BenchRay& from) const {
    RTCRayHit query{};
    query.ray = to_ray(from);
    query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    query.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
    rtcIntersect1(scene_, &context, &query);
    return query.hit.geomID == RTC_INVALID_GEOMETRY_ID ? BenchHit{} : BenchHit{query.ray.tfar, query.hit.primID};
  }
  // Embree says no more of an occluded ray than that it is.
  BenchHit occluded(RTCIntersectContext& context, const BenchRay& from) const {
    RTCRay ray = to_ray(from);
    rtcOccluded1(scene_, &context, &ray);
    return ray.tfar < 0 ? BenchHit{0, 0} : BenchHit{};
  }

  static bool on_memory(void* self, ssize_t bytes, bool /*post*/) {
    static_cast<EmbreeEngine*>(self)->bytes_ += bytes;
    return true;
  }

  // OK, or Embree's last error.
  Status fault(const char* call) {
    const RTCError error = rtcGetDeviceError(device_);
    if (error == RTC_ERROR_NONE) return {};
    return Error{ErrorCode::kDevice, std::string(call) + " failed with RTCError " + std::to_string(error)};
  }

  void weld(std::span<const BenchTriangle> triangles) {
    std::map<std::array<float, 3>, std::uint32_t> known;
    for (const BenchTriangle& triangle : triangles) {
      for (std::size_t corner = 0; corner < 9; corner += 3) {
        const std::array<float, 3> p = {triangle.v[corner], triangle.v[corner + 1], triangle.v[corner + 2]};
        const auto [at, fresh] = known.try_emplace(p, static_cast<std::uint32_t>(known.size()));
        if (fresh) vertices_.insert(vertices_.end(), p.begin(), p.end());
        indices_.push_back(at->second);
      }
    }
    vertices_.insert(vertices_.end(), 3, 0.0F);
  }

  bool robust_;
  bool any_hit_;
  unsigned threads_;
  std::vector<float> vertices_;
  std::vector<std::uint32_t> indices_;
  RTCDevice device_ = nullptr;
  RTCScene scene_ = nullptr;
  std::atomic<std::int64_t> bytes_ = 0;
  BuildFigures figures_;
};

}  // namespace

bool has_embree() { return true; }

std::unique_ptr<TraceEngine> make_embree_engine(bool robust, bool any_hit, unsigned threads) {
  return std::make_unique<EmbreeEngine>(robust, any_hit, threads);
}

}  // namespace zc::bench
#else
namespace zc::bench {

bool has_embree() { return false; }

std::unique_ptr<TraceEngine> make_embree_engine(bool /*robust*/, bool /*any_hit*/, unsigned /*threads*/) {
  return nullptr;
}

}  // namespace zc::bench
#endif
