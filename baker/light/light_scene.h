// SPDX-License-Identifier: GPL-3.0-or-later
// A city at full detail for rays of light, all of it or the parts that some zones see: Embree over the detail nodes, as
// decoded, with each triangle's colour and how much of the sun it sends on. Built and asked by any threads; the same
// answers every time for the same parts (Embree's own builder runs on one thread, and one instruction set is fixed).
// Units: metres from the world's anchor, single precision; where the world is too wide for that, from a frame of each
// scene's own.
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "baker/scene/lattice_mesh.h"
#include "baker/scene/scene.h"
#include "base/result.h"
#include "streamer/world_format/bvh_page.h"

struct RTCDeviceTy;

namespace zc {

// Farther from its anchor than this in any direction, a world is wide: single precision is off by 4 mm there.
inline constexpr double kWideWorldM = 65536;
// Directions to suns that bounced light is measured for.
inline constexpr std::size_t kBounceSuns = 7;
const std::array<glm::vec3, kBounceSuns>& bounce_suns();

// The triangles of all detail nodes.
struct LightDetail {
  using Sunlight = std::array<std::int8_t, kBounceSuns>;
  struct Part {  // a detail node
    std::uint32_t node = 0;
    std::uint32_t first = 0;  // triangle
    std::uint32_t count = 0;
    glm::vec3 low{0};
    glm::vec3 high{0};
  };

  LightDetail(std::span<const ZoneMesh> meshes, std::span<const NodeRecord> nodes, std::span<const Material> materials,
              double step_m);
  // For rays alone: one part, without albedo.
  LightDetail(const LatticeMesh& mesh, double step_m);

  std::vector<Part> parts;         // in the order of the nodes
  std::vector<glm::vec3> corners;  // three a triangle
  std::vector<glm::dvec3> exact;   // the same, of a world that is too wide for single precision; else empty
  std::vector<glm::vec3> albedo;   // per triangle, as everything below
  std::vector<glm::vec3> normal;   // unit
  std::vector<Sunlight> sunlight;  // of each sun, of 127; negative: on the back
  float bias_m = 0;                // how far from a surface rays start, so that they do not hit it again

 private:
  void add(const std::array<glm::dvec3, 3>& triangle);  // to the last part
  void finish();

  bool is_wide_ = false;
};

// What a scene's rays and triangles are relative to.
struct LightFrame {
  glm::dvec3 origin{0};
  float bias_m = 0;  // as that of the detail

  // Of a box that all rays start in: the world's own frame unless the world is too wide for it.
  static LightFrame around(const LightDetail& detail, const glm::vec3& low, const glm::vec3& high);
};

// Embree itself. While one lives TBB has no more than one thread.
class LightDevice {
 public:
  static Result<LightDevice> create();
  LightDevice(LightDevice&& other) noexcept;
  LightDevice& operator=(LightDevice&&) = delete;
  ~LightDevice();
  [[nodiscard]] RTCDeviceTy* handle() const { return device_; }

 private:
  explicit LightDevice(RTCDeviceTy* device) : device_(device) {}
  RTCDeviceTy* device_;
};

class LightScene {
 public:
  struct Hit {
    float distance_m = 0;
    std::uint32_t triangle = 0;
    bool from_behind = false;
  };

  // Of the parts of a detail by number; borrows both, which must outlive it. Fails when Embree refuses.
  static Result<LightScene> build(const LightDevice& device, const LightDetail& detail,
                                  std::span<const std::uint32_t> parts, const LightFrame& frame);
  // Of a whole world, with its sunlight measured.
  static Result<LightScene> build(std::span<const ZoneMesh> meshes, std::span<const NodeRecord> nodes,
                                  std::span<const Material> materials, double step_m, unsigned threads);
  LightScene(LightScene&&) noexcept;
  LightScene& operator=(LightScene&&) = delete;
  ~LightScene();

  [[nodiscard]] std::optional<Hit> closest(const glm::vec3& origin, const glm::vec3& direction, float far_m) const;
  // The same for eight rays from one point. Without a hit: a distance that is not finite.
  static constexpr std::size_t kPacket = 8;
  [[nodiscard]] std::array<Hit, kPacket> closest(const glm::vec3& origin,
                                                 std::span<const glm::vec3, kPacket> directions, float far_m) const;
  [[nodiscard]] bool blocked(const glm::vec3& origin, const glm::vec3& direction, float far_m) const;

  // A triangle's share of each sun's light, by rays from four points of it.
  [[nodiscard]] LightDetail::Sunlight measure_sunlight(std::uint32_t triangle) const;

  // By the detail's number of a triangle.
  [[nodiscard]] const glm::vec3& albedo(std::uint32_t triangle) const { return detail_->albedo[triangle]; }
  [[nodiscard]] const glm::vec3& normal(std::uint32_t triangle) const { return detail_->normal[triangle]; }
  // Mean share of the k-th sun's light that falls on the side that was hit, 0..1.
  [[nodiscard]] float sunlight(const Hit& hit, std::size_t k) const;
  [[nodiscard]] float bias_m() const { return frame_.bias_m; }
  [[nodiscard]] const glm::dvec3& origin() const { return frame_.origin; }
  // Triangles that rays are tested against, pieces counted one by one.
  [[nodiscard]] std::size_t primitives() const { return triangles_.size(); }

 private:
  struct Handles;
  LightScene(const LightDetail& detail, const LightFrame& frame);
  // Of a triangle of the detail, in this frame.
  [[nodiscard]] std::array<glm::vec3, 3> corners_of(std::uint32_t triangle) const;
  // Where triangles lie askew over each other a ray hits many of their boxes: they are cut until it hits few.
  void cut_wasteful();
  [[nodiscard]] Hit hit(unsigned primitive, float distance_m, const glm::vec3& direction) const;

  std::unique_ptr<LightDevice> own_device_;  // of a whole world, as the next
  std::unique_ptr<LightDetail> own_detail_;
  const LightDetail* detail_;
  LightFrame frame_;
  std::vector<std::uint32_t> triangles_;  // per triangle of Embree's: the detail's
  std::vector<glm::vec3> own_corners_;    // three a triangle of Embree's where they are not the detail's; else empty
  std::unique_ptr<Handles> handles_;
};

}  // namespace zc
