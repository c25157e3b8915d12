// SPDX-License-Identifier: Apache-2.0
// How a `.zbvh` codes the appearance of its triangles, in the order of the decoded mesh: neighbours mostly look alike,
// and what is stored for a vertex (light, normals) comes again with the next triangle there.
// Each part has a coder of its own, so that only the models of one are in memory at a time.
// Untrusted input: counts are compared with the header's, and a symbol is always in its range. Borrows the coder.
// Threads: one at a time. Fails when: the appearances or curved triangles are more or fewer than the header says.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "streamer/world_format/bvh_page.h"
#include "streamer/world_format/coding/light_order.h"
#include "streamer/world_format/coding/range_coder.h"

namespace zc {

template <class Coder>
class MaterialCode {
 public:
  explicit MaterialCode(Coder& coder) : coder_(coder) {}

  // The triangles' materials: mostly as before, else by how many others came since, else by number.
  void run(std::vector<std::uint16_t>& of, std::size_t triangles) {
    if (!Coder::kEncodes) of.resize(triangles);
    std::vector<std::uint16_t> recent;  // the latest first
    std::uint32_t same_before = 0;
    for (std::size_t t = 0; t < triangles; ++t) {
      std::uint32_t rank = 0;
      if (Coder::kEncodes) rank = static_cast<std::uint32_t>(std::ranges::find(recent, of[t]) - recent.begin());
      std::uint32_t changed = rank != 0 ? 1 : 0;
      if (t > 0) coder_.bit(changed_[same_before], changed);
      if (t == 0 || changed != 0) {
        if (t > 0) {
          --rank;
          rank_.code(coder_, rank);
          rank = std::min(rank, static_cast<std::uint32_t>(recent.size()) - 1) + 1;
        }
        if (rank == recent.size()) {
          if (rank == kRecentMost)
            --rank;
          else
            recent.emplace_back();
          std::uint32_t low = of[t] & 0xFFU;
          std::uint32_t high = of[t] >> 8U;
          material_low_.code(coder_, low);
          material_high_.code(coder_, high);
          recent[rank] = static_cast<std::uint16_t>(low | high << 8U);
        }
        std::rotate(recent.begin(), recent.begin() + rank, recent.begin() + rank + 1);
      }
      same_before = changed == 0 && t > 0 ? 1 : 0;
      of[t] = recent.front();
    }
  }

 private:
  static constexpr std::size_t kRecentMost = 256;  // a bound on the work of a triangle

  Coder& coder_;
  std::array<Bit, 2> changed_;
  Number rank_;
  Symbol<8> material_low_;
  Symbol<8> material_high_;
};

// Encoding, the appearances are numbered by first use; decoding, there are none before.
template <class Coder>
class AppearanceCode {
 public:
  explicit AppearanceCode(Coder& coder) : coder_(coder) {}

  // Why it cannot be decoded, or nothing.
  const char* run(const BvhFileHeader& header, std::size_t triangles, ZoneAppearance& appearance) {
    if (!Coder::kEncodes) {
      appearance.appearance_of.resize(triangles);
      appearance.appearances.reserve(header.appearance_count);
    }
    std::uint32_t known = 0;
    std::uint32_t same_before = 0;
    std::uint32_t last = 0;
    for (std::size_t t = 0; t < triangles; ++t) {
      std::uint32_t number = appearance.appearance_of[t];
      std::uint32_t same = number == last ? 1 : 0;
      if (t > 0) coder_.bit(same_appearance_[same_before], same);
      if (t == 0 || same == 0) {
        same = 0;
        std::uint32_t fresh = number == known ? 1 : 0;
        if (t > 0) coder_.bit(fresh_appearance_, fresh);
        if (t == 0 || fresh != 0) {
          if (known == header.appearance_count) return "more appearances than the header says";
          number = known++;
          if (!Coder::kEncodes) appearance.appearances.emplace_back();
          code_appearance(appearance.appearances[number]);
        } else {
          std::uint32_t back = known - 1 - number;
          steps_back_.code(coder_, back);
          if (back >= known) return "a triangle's appearance is out of range";
          number = known - 1 - back;
        }
      } else {
        number = last;
      }
      same_before = same;
      last = number;
      appearance.appearance_of[t] = static_cast<std::uint16_t>(number);
    }
    return known == header.appearance_count ? nullptr : "fewer appearances than the header says";
  }

 private:
  void code_appearance(gpu::Appearance& appearance) {
    std::uint32_t low = appearance.material & 0xFFU;
    std::uint32_t high = appearance.material >> 8U & 0xFFU;
    std::uint32_t kind = appearance.material >> 16U & 0x7FU;
    material_low_.code(coder_, low);
    material_high_.code(coder_, high);
    appearance_kind_.code(coder_, kind);
    std::uint32_t gain = appearance.material >> 23U & 0xFFU;
    appearance_gain_.code(coder_, gain);
    std::uint32_t place = 0;
    for (unsigned half = 0; half < 2; ++half) {
      const std::uint32_t before = place_before_ >> (16 * half) & 0xFFFFU;
      std::int32_t change = static_cast<std::int16_t>((appearance.place >> (16 * half)) - before);
      place_change_[half].code(coder_, change);
      place |= ((before + static_cast<std::uint32_t>(change)) & 0xFFFFU) << (16 * half);
    }
    place_before_ = place;
    appearance = {low | high << 8U | kind << 16U | gain << 23U, place};
  }

  Coder& coder_;
  std::array<Bit, 2> same_appearance_;
  Bit fresh_appearance_;
  Number steps_back_;
  Symbol<8> material_low_;
  Symbol<8> material_high_;
  Symbol<7> appearance_kind_;
  Symbol<8> appearance_gain_;
  std::array<SignedNumber, 2> place_change_;
  std::uint32_t place_before_ = 0;
};

template <class Coder>
class LightCode {
 public:
  LightCode(Coder& coder, const ZoneMesh& mesh, std::vector<gpu::TriangleLight>& light)
      : coder_(coder), mesh_(mesh), light_(light) {}

  void run() {
    if (!Coder::kEncodes) light_.resize(mesh_.triangles.size());
    code_sky_values();
    LightOrder order(mesh_);
    for (std::uint32_t t = 0; t < mesh_.triangles.size(); ++t) {
      const LightOrder::Place place = order.place(t);
      const gpu::TriangleLight guess =
          place.neighbour == LightOrder::kNone ? gpu::TriangleLight{} : light_[place.neighbour];
      gpu::TriangleLight& light = light_[t];
      const std::uint32_t sky = code_sky(t, order, place, guess.sky & 0xFFU, light.sky);
      light = code_bounce(place.is_near, BouncedLight(guess), BouncedLight(light)).pack();
      light.sky |= sky;
      order.add(t, place.facing);
    }
  }

 private:
  struct BounceModels {
    Bit same;
    std::array<std::array<Change<6>, 3>, 4> change;
    std::array<Change<8>, 3> variation;
    std::array<Symbol<2>, 4> sun;
    std::array<Change<4>, 2> direction;
  };

  // Of 256, few come: they are numbered in turn.
  void code_sky_values() {
    std::array<std::uint32_t, 256> used{};
    if (Coder::kEncodes)
      for (const gpu::TriangleLight& light : light_)
        for (unsigned k = 0; k < 3; ++k) used[light.sky >> (8 * k) & 0xFFU] = 1;
    std::array<Bit, 1> model;
    sky_value_.reserve(256);
    for (std::uint32_t value = 0; value < 256; ++value) {
      coder_.bit(model[0], used[value]);
      sky_number_[value] = static_cast<std::uint32_t>(sky_value_.size());
      if (used[value] != 0) sky_value_.push_back(value);
    }
    if (sky_value_.empty()) sky_value_.push_back(0);
  }

  std::uint32_t code_sky(std::uint32_t triangle, const LightOrder& order, const LightOrder::Place& place,
                         std::uint32_t guess, std::uint32_t sky) {
    std::uint32_t coded = 0;
    std::uint32_t known_before = 0;
    std::uint32_t before = guess;
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t other = place.at_corner[k];
      std::uint32_t value = sky >> (8 * k) & 0xFFU;
      std::uint32_t same = 0;
      if (other != LightOrder::kNone) {
        before = order.sky_at(light_[other], other, mesh_.triangles[triangle][k]);
        same = value == before ? 1 : 0;
        coder_.bit(same_sky_[known_before], same);
        known_before = 1 + same;
        if (same != 0) value = before;
      }
      if (same == 0) {
        std::uint32_t change = (sky_number_[value] - sky_number_[before]) & 0xFFU;
        sky_change_[other != LightOrder::kNone ? 3 : k].code(coder_, change);
        const std::uint32_t number = (sky_number_[before] + change) & 0xFFU;
        value = sky_value_[std::min<std::size_t>(number, sky_value_.size() - 1)];
      }
      coded |= value << (8 * k);
      before = value;
    }
    return coded;
  }

  BouncedLight code_bounce(bool is_near, const BouncedLight& guess, BouncedLight value) {
    BounceModels& models = bounce_[is_near ? 1 : 0];
    std::uint32_t same = value == guess ? 1 : 0;
    coder_.bit(models.same, same);
    if (same != 0) return guess;
    std::uint32_t context = 1;  // how the level before changed
    for (std::size_t f = 0; f < value.levels.size(); ++f) {
      const std::uint32_t most = BouncedLight::kMost[f];
      std::uint32_t change = (value.levels[f] - guess.levels[f]) & most;
      if (f + 1 < value.levels.size())
        models.change[f][context].code(coder_, change);
      else
        models.variation[context].code(coder_, change);
      value.levels[f] = (guess.levels[f] + change) & most;
      context = change == 0 ? 1 : 2 * change <= most ? 2 : 0;
    }
    models.sun[guess.sun].code(coder_, value.sun);
    for (std::size_t axis = 0; axis < 2; ++axis) {
      std::uint32_t change = (value.direction[axis] - guess.direction[axis]) & 15U;
      models.direction[axis].code(coder_, change);
      value.direction[axis] = (guess.direction[axis] + change) & 15U;
    }
    return value;
  }

  Coder& coder_;
  const ZoneMesh& mesh_;
  std::vector<gpu::TriangleLight>& light_;
  std::vector<std::uint32_t> sky_value_;
  std::array<std::uint32_t, 256> sky_number_{};
  std::array<Bit, 3> same_sky_;
  std::array<Change<8>, 4> sky_change_;
  std::array<BounceModels, 2> bounce_;
};

template <class Coder>
class NormalCode {
 public:
  explicit NormalCode(Coder& coder) : coder_(coder) {}

  // Why it cannot be decoded, or nothing.
  const char* run(const BvhFileHeader& header, const ZoneMesh& mesh, ZoneAppearance& appearance) {
    if (!Coder::kEncodes) {
      appearance.curved.reserve(header.curved_count);
      appearance.normals.reserve(header.curved_count);
    }
    std::vector<std::array<std::uint16_t, 2>> at_vertex(mesh.vertices.size(), {kUnknown, kUnknown});
    std::array<std::uint16_t, 2> last = {512, 512};
    std::uint32_t curved_before = 0;
    std::size_t next = 0;
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
      std::uint32_t curved = Coder::kEncodes && next < appearance.curved.size() && appearance.curved[next] == t ? 1 : 0;
      coder_.bit(curved_[curved_before], curved);
      curved_before = curved;
      if (curved == 0) continue;
      if (next == header.curved_count) return "more curved triangles than the header says";
      if (!Coder::kEncodes) {
        appearance.curved.push_back(t);
        appearance.normals.emplace_back();
      }
      gpu::TriangleNormals& normals = appearance.normals[next++];
      const std::uint64_t packed =
          (normals.first_second & 0x3FFFFFFFU) | std::uint64_t{normals.second_third & 0x3FFFFFFFU} << 30U;
      std::uint64_t coded = 0;
      for (std::size_t k = 0; k < 3; ++k) {
        std::array<std::uint16_t, 2>& known = at_vertex[mesh.triangles[t][k]];
        const std::array<std::uint16_t, 2> guess = known[0] != kUnknown ? known : last;
        for (std::size_t axis = 0; axis < 2; ++axis) {
          const auto shift = static_cast<unsigned>(20 * k + 10 * axis);
          auto value = static_cast<std::uint32_t>(packed >> shift & 0x3FFU);
          auto change = static_cast<std::int32_t>(value) - guess[axis];
          normal_change_[known[0] != kUnknown ? 1 : 0].code(coder_, change);
          value = static_cast<std::uint32_t>(guess[axis] + static_cast<std::int64_t>(change)) & 0x3FFU;
          last[axis] = static_cast<std::uint16_t>(value);
          coded |= std::uint64_t{value} << shift;
        }
        known = last;
      }
      normals.first_second = static_cast<std::uint32_t>(coded & 0x3FFFFFFFU);
      normals.second_third = static_cast<std::uint32_t>(coded >> 30U);
    }
    return next == header.curved_count ? nullptr : "fewer curved triangles than the header says";
  }

 private:
  static constexpr std::uint16_t kUnknown = 0xFFFF;

  Coder& coder_;
  std::array<Bit, 2> curved_;
  std::array<SignedNumber, 2> normal_change_;
};

}  // namespace zc
