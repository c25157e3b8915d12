// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/import/shared/opaque_part.h"

#include <algorithm>
#include <utility>

#include "baker/import/shared/scene_builder.h"

namespace zc {
namespace {

void cut_by_mask(const Coverage& coverage, float cutoff, const SurfacePart& part) {
  constexpr std::size_t kPiecesPerTriangle = 256;
  constexpr std::size_t kPiecesLeast = 1U << 13U;  // a fence may be two triangles
  constexpr std::size_t kPiecesMost = 1U << 17U;
  std::vector<AlphaMask::Triangle> triangles;
  triangles.reserve(part.triangles.size());
  for (const auto& [a, b, c] : part.triangles)
    triangles.push_back({{part.texcoords[a], part.texcoords[b], part.texcoords[c]}});
  const std::size_t most =
      std::max(triangles.size(), std::clamp(kPiecesPerTriangle * triangles.size(), kPiecesLeast, kPiecesMost));
  const AlphaMask::Cut cut = coverage.mask->cut(triangles, coverage.wrap_u, coverage.wrap_v, cutoff, most);
  if (cut.is_whole) return;
  std::vector<glm::dvec3> positions;
  std::vector<glm::vec2> texcoords;
  std::vector<std::array<std::uint32_t, 3>> pieces;
  std::vector<std::uint16_t> materials;
  for (std::size_t i = 0; i < cut.pieces.size(); ++i) {
    const auto& corners = part.triangles[cut.of[i]];
    const auto first = static_cast<std::uint32_t>(positions.size());
    for (const glm::vec3& shares : cut.pieces[i]) {
      glm::dvec3 position(0);
      glm::vec2 uv(0);
      for (std::size_t c = 0; c < 3; ++c) {
        const float share = shares[static_cast<int>(c)];
        position += static_cast<double>(share) * part.positions[corners[c]];
        uv += share * part.texcoords[corners[c]];
      }
      positions.push_back(position);
      texcoords.push_back(uv);
    }
    pieces.push_back({first, first + 1, first + 2});
    materials.push_back(part.materials[cut.of[i]]);
  }
  part.positions = std::move(positions);
  part.texcoords = std::move(texcoords);
  part.triangles = std::move(pieces);
  part.materials = std::move(materials);
}

}  // namespace

void keep_opaque(const Coverage& coverage, const std::string& format, const SurfacePart& part, SceneBuilder& builder) {
  const AlphaMask* mask = coverage.mask;
  const double factor = coverage.factor;
  const double cutoff = coverage.cutoff;
  const double share = mask != nullptr && factor > 0 ? mask->share_at_least(static_cast<float>(cutoff / factor))
                                                     : (factor >= cutoff ? 1.0 : 0.0);
  if (share == 1) return;
  constexpr double kPaneShare = 0.01;
  if (coverage.keeps_panes && share < kPaneShare) {
    builder.note("transparent " + format + " surfaces, kept as panes that are opaque", part.triangles.size());
    return;
  }
  if (mask == nullptr || part.texcoords.empty()) {
    if (share > 0) return;
    builder.remark(format + " triangles that their alpha leaves nothing of, left out", part.triangles.size());
    part.triangles.clear();
    part.materials.clear();
    return;
  }
  builder.remark(format + " triangles with transparent parts, which were cut off", part.triangles.size());
  cut_by_mask(coverage, static_cast<float>(cutoff / factor), part);
}

}  // namespace zc
