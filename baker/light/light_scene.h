// SPDX-License-Identifier: GPL-3.0-or-later
// The whole city at full detail for rays of light: Embree over the detail nodes, as decoded, with each triangle's
// colour and how much of the sun it sends on. Built and asked by any threads; the same answers every time (Embree's own
// builder runs on one thread, and one instruction set is fixed). Units: metres from the world's anchor, single
// precision. Owns its copy.
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "baker/scene.h"
#include "base/result.h"
#include "streamer/world_format/bvh_page.h"

namespace zc {

// Directions to suns that bounced light is measured for.
inline constexpr std::size_t kBounceSuns = 7;
const std::array<glm::vec3, kBounceSuns>& bounce_suns();

class LightScene {
 public:
  struct Hit {
    float distance_m = 0;
    std::uint32_t triangle = 0;
    bool from_behind = false;
  };

  // Fails when Embree refuses. meshes and nodes: of the whole world; only the details are taken.
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

  [[nodiscard]] const glm::vec3& albedo(std::uint32_t triangle) const { return albedo_[triangle]; }
  [[nodiscard]] const glm::vec3& normal(std::uint32_t triangle) const { return normal_[triangle]; }
  // Mean share of the k-th sun's light that falls on the side that was hit, 0..1.
  [[nodiscard]] float sunlight(const Hit& hit, std::size_t k) const;
  // How far from a surface rays start, so that they do not meet it again.
  [[nodiscard]] float bias_m() const { return bias_m_; }

 private:
  struct Handles;
  LightScene();
  void measure_sunlight(unsigned threads);

  std::unique_ptr<Handles> handles_;
  std::vector<glm::vec3> vertices_;  // three a triangle; Embree reads them in place
  std::vector<glm::vec3> albedo_;
  std::vector<glm::vec3> normal_;
  std::vector<std::array<std::int8_t, kBounceSuns>> sunlight_;  // of 127; negative: on the back
  float bias_m_ = 0;
};

}  // namespace zc
