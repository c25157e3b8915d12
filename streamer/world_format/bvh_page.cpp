// SPDX-License-Identifier: Apache-2.0
// The `.zbvh` codec. Assembling a page is in page_assembly.cpp, checking one in page_check.cpp.
#include "streamer/world_format/bvh_page.h"

#include <algorithm>
#include <cstring>
#include <functional>
#include <memory>

#include "base/check.h"
#include "streamer/world_format/coding/appearance_code.h"
#include "streamer/world_format/coding/range_coder.h"
#include "streamer/world_format/coding/tree_code.h"
#include "streamer/world_format/leaf_boxes.h"
#include "streamer/world_format/page_view.h"
#include "streamer/world_format/scratch_memory.h"

namespace zc {
namespace {

BvhFileHeader header_of(const BvhFile& bvh) {
  const ZoneAppearance& appearance = bvh.appearance;
  BvhFileHeader header;
  header.flags = (bvh.split ? gpu::kPageSplitTriangles : 0) | appearance.page_flags();
  header.appearance_count = static_cast<std::uint32_t>(appearance.appearances.size());
  header.curved_count = static_cast<std::uint32_t>(appearance.curved.size());
  header.atlas_size = appearance.atlas_size;
  header.texels_per_step = appearance.texels_per_step;
  return header;
}

// By first use; those of no triangle go.
void number_appearances(ZoneAppearance& appearance) {
  std::vector<std::uint32_t> number(appearance.appearances.size(), UINT32_MAX);
  std::vector<gpu::Appearance> used;
  for (std::uint16_t& of : appearance.appearance_of) {
    if (number[of] == UINT32_MAX) {
      number[of] = static_cast<std::uint32_t>(used.size());
      used.push_back(appearance.appearances[of]);
    }
    of = static_cast<std::uint16_t>(number[of]);
  }
  appearance.appearances = std::move(used);
}

template <class Coder>
void code_trims(Coder& coder, std::vector<LeafTrim>& trims) {
  std::array<Symbol<6>, 6> models;
  for (LeafTrim& trim : trims)
    for (std::size_t side = 0; side < trim.size(); ++side) {
      std::uint32_t value = trim[side];
      models[side].code(coder, value);
      trim[side] = static_cast<std::uint8_t>(value);
    }
}

// The part of the file that is coded, behind the tree and the trims.
template <class Coder>
const char* code_appearances(Coder& coder, ZoneMesh& mesh, const BvhFileHeader& header, ZoneAppearance& appearance,
                             const std::function<void(std::uint64_t BvhFileParts::*)>& done) {
  if ((header.flags & gpu::kPageAppearances) != 0) {
    if (const char* fault =
            std::make_unique<AppearanceCode<Coder>>(coder)->run(header, mesh.triangles.size(), appearance))
      return fault;
    mesh.materials.resize(appearance.appearance_of.size());
    for (std::size_t t = 0; t < appearance.appearance_of.size(); ++t)
      mesh.materials[t] = static_cast<std::uint16_t>(appearance.appearances[appearance.appearance_of[t]].material);
    done(&BvhFileParts::appearances);
  } else {
    std::make_unique<MaterialCode<Coder>>(coder)->run(mesh.materials, mesh.triangles.size());
    done(&BvhFileParts::materials);
  }
  if ((header.flags & gpu::kPageLight) != 0) std::make_unique<LightCode<Coder>>(coder, mesh, appearance.light)->run();
  done(&BvhFileParts::light);
  if ((header.flags & gpu::kPageNormals) != 0)
    if (const char* fault = std::make_unique<NormalCode<Coder>>(coder)->run(header, mesh, appearance)) return fault;
  done(&BvhFileParts::normals);
  return nullptr;
}

// Nothing takes more memory than the record says, which is what has been reserved.
const char* check_header(const BvhFileHeader& header, const NodeRecord& node) {
  if ((header.flags & ~gpu::kPageFlags) != 0) return "unknown flags";
  const auto counts = [&](std::uint32_t flag, std::uint32_t count, std::size_t most) {
    return (header.flags & flag) != 0 ? count > 0 && count <= most : count == 0;
  };
  const std::size_t appearances_most =
      std::min<std::size_t>(node.appearance_bytes / sizeof(gpu::Appearance), kZoneAppearancesMax);
  if (!counts(gpu::kPageAppearances, header.appearance_count,
              std::min<std::size_t>(appearances_most, node.triangle_count)))
    return "appearance count out of range";
  const std::size_t curved_most = node.normal_bytes / sizeof(gpu::TriangleNormals);
  if (!counts(gpu::kPageNormals, header.curved_count, std::min<std::size_t>(curved_most, node.triangle_count)))
    return "number of curved triangles out of range";
  if (((header.flags & gpu::kPageLight) != 0) != (node.light_bytes > 0)) return "light that the index does not know";
  const AtlasShape atlas = AtlasShape::unpack(header.atlas_size);
  if (header.atlas_size != 0 && ((header.flags & gpu::kPageAppearances) == 0 || !atlas.valid() ||
                                 sizeof(std::uint32_t) * atlas.words() != node.texture_bytes))
    return "atlas size out of range";
  return nullptr;
}

}  // namespace

// One stage after the other; each has the mesh, and from the boxes on the tree.
std::uint32_t page_scratch_bytes(const NodeRecord& node, std::uint64_t vertex_count) {
  const std::uint64_t triangles = node.triangle_count;
  const std::uint64_t references = node.reference_count;
  const std::uint64_t nodes = node.bvh_node_count;
  const std::uint64_t clusters = std::min(nodes, references);
  const auto grown = [](std::uint64_t count) { return 3 * count; };  // by doubling: the old and the new array
  const std::uint64_t mesh = array_scratch<std::array<std::uint32_t, 3>>(triangles) +
                             array_scratch<std::array<std::uint16_t, 3>>(vertex_count);
  const std::uint64_t tree = array_scratch<gpu::PageNode>(nodes) + array_scratch<std::uint32_t>(references);

  const std::uint64_t waiting = std::min(nodes, std::uint64_t{gpu::kNodeWidth} * node.bvh_depth);
  const std::uint64_t tree_stage =
      mesh + tree + sizeof(TreeCode<Decoder>) + array_scratch<std::uint32_t>(grown(clusters)) +
      array_scratch<std::uint32_t>(references) + array_scratch<std::uint32_t>(triangles) +
      array_scratch<std::uint8_t>(triangles) + array_scratch<std::array<std::uint32_t, 4>>(grown(waiting));

  const std::uint64_t repeated = references - std::min(references, triangles);
  const std::uint64_t cut_leaves = repeated == 0 ? 0 : std::min(references, gpu::kNodeWidth * nodes);
  const std::uint64_t bits = array_scratch<std::uint64_t>(triangles / 64 + 1);
  const std::uint64_t held =
      mesh + tree + array_scratch<std::uint32_t>(2 * clusters) + array_scratch<LeafTrim>(cut_leaves);
  const std::uint64_t box_stage = held + array_scratch<std::uint8_t>(nodes) + 2 * bits + array_scratch<NodeBox>(nodes);

  std::uint64_t appearances = array_scratch<std::uint16_t>(triangles);
  if (node.appearance_bytes > 0)
    appearances += array_scratch<std::uint16_t>(triangles) + array_scratch<std::uint8_t>(node.appearance_bytes);
  if (node.light_bytes > 0) appearances += array_scratch<gpu::TriangleLight>(triangles);
  const std::uint64_t curved = std::min<std::uint64_t>(triangles, node.normal_bytes / sizeof(gpu::TriangleNormals));
  if (curved > 0) appearances += array_scratch<std::uint32_t>(curved) + array_scratch<gpu::TriangleNormals>(curved);
  std::uint64_t at_vertices = 0;
  if (node.light_bytes > 0) at_vertices = LightOrder::scratch_bytes(triangles, vertex_count);
  if (curved > 0) at_vertices = std::max(at_vertices, array_scratch<std::array<std::uint16_t, 2>>(vertex_count));
  const std::uint64_t models =
      std::max({node.appearance_bytes > 0 ? sizeof(AppearanceCode<Decoder>) : sizeof(MaterialCode<Decoder>),
                node.light_bytes > 0 ? sizeof(LightCode<Decoder>) + array_scratch<std::uint32_t>(256) : 0,
                curved > 0 ? sizeof(NormalCode<Decoder>) : 0});
  const std::uint64_t appearance_stage = held + models + appearances + at_vertices;

  const std::uint64_t palette =
      node.appearance_bytes > 0 ? node.appearance_bytes / sizeof(gpu::Appearance) : references + clusters;
  const std::uint64_t checks =
      std::max(array_scratch<std::uint8_t>(nodes) + array_scratch<std::uint64_t>(references / 64 + 1),
               bits + array_scratch<PieceOfTriangle>(repeated));
  const std::uint64_t page_stage = held + appearances + array_scratch<std::uint8_t>(node.texture_bytes) +
                                   2 * array_scratch<std::uint32_t>(clusters) +
                                   std::max(array_scratch<std::uint16_t>(grown(palette)), checks);

  constexpr std::uint64_t kFixed = 4 << 10U;  // one cluster, one palette, names
  return clamp_bytes(std::max({tree_stage, box_stage, appearance_stage, page_stage}) + kFixed);
}

EncodedBvh encode_bvh_file(const BvhFile& bvh, const ZoneMesh& mesh, const NodeRecord& node) {
  ZC_CHECK(bvh.nodes.size() == node.bvh_node_count && bvh.order.size() == node.reference_count &&
           bvh.depth == node.bvh_depth && bvh.trims.size() == count_leaves(leaves_with_pieces(bvh)));
  EncodedBvh out;
  ZoneAppearance appearance = bvh.appearance;
  number_appearances(appearance);
  BvhFileHeader header = header_of(bvh);
  header.appearance_count = static_cast<std::uint32_t>(appearance.appearances.size());
  Encoder coder;
  std::uint64_t before = 0;
  const auto done = [&](std::uint64_t BvhFileParts::*part) {
    out.parts.*part += coder.size() - before;
    before = coder.size();
  };
  const auto tree = std::make_unique<TreeCode<Encoder>>(coder, mesh, node, bvh.split, &bvh);
  ZC_CHECK(tree->run() == nullptr);
  std::vector<LeafTrim> trims = bvh.trims;
  code_trims(coder, trims);
  done(&BvhFileParts::tree);
  ZoneMesh copy = mesh;  // written to as well: one function for both directions
  ZC_CHECK(mesh.materials.size() == mesh.triangles.size() &&
           code_appearances(coder, copy, header, appearance, done) == nullptr);
  const std::vector<std::byte> coded = coder.finish();
  out.parts.tree += sizeof header + coded.size() - before;
  out.parts.texture = sizeof(std::uint32_t) * appearance.atlas.size();

  out.bytes.resize(sizeof header + coded.size() + out.parts.texture);
  std::memcpy(out.bytes.data(), &header, sizeof header);
  std::ranges::copy(coded, out.bytes.begin() + sizeof header);
  if (!appearance.atlas.empty())
    std::memcpy(out.bytes.data() + sizeof header + coded.size(), appearance.atlas.data(), out.parts.texture);
  return out;
}

Result<BvhFile> decode_bvh_file(std::span<const std::byte> bytes, ZoneMesh& mesh, const NodeRecord& node,
                                const std::string& path) {
  const auto fault = [&](const char* cause, std::size_t at) {
    return Error{ErrorCode::kFormat, cause, path, static_cast<std::int64_t>(at)};
  };
  BvhFileHeader header;
  if (bytes.size() < sizeof header) return fault("too short for a BVH file", bytes.size());
  std::memcpy(&header, bytes.data(), sizeof header);
  if (header.magic != BvhFileHeader{}.magic) return fault("not a zonecast BVH file of this version", 0);
  if (mesh.triangles.empty() || mesh.triangles.size() != node.triangle_count)
    return fault("mesh and index disagree on the number of triangles", 0);
  if (const char* cause = check_header(header, node)) return fault(cause, offsetof(BvhFileHeader, flags));
  const std::size_t atlas_words = header.atlas_size == 0 ? 0 : AtlasShape::unpack(header.atlas_size).words();
  if (bytes.size() - sizeof header < sizeof(std::uint32_t) * atlas_words)
    return fault("too short for its atlas", bytes.size());

  Decoder coder(bytes.subspan(sizeof header, bytes.size() - sizeof header - sizeof(std::uint32_t) * atlas_words));
  BvhFile bvh;
  {
    const bool split = (header.flags & gpu::kPageSplitTriangles) != 0;
    const auto tree = std::make_unique<TreeCode<Decoder>>(coder, mesh, node, split, nullptr);
    if (const char* cause = tree->run()) return fault(cause, sizeof header);
    bvh = std::move(*tree).take();
  }
  bvh.trims.resize(count_leaves(leaves_with_pieces(bvh)));
  code_trims(coder, bvh.trims);
  ZC_TRY(fit_boxes(bvh, mesh, node, path));
  ZoneAppearance& appearance = bvh.appearance;
  if (const char* cause = code_appearances(coder, mesh, header, appearance, [](std::uint64_t BvhFileParts::*) {}))
    return fault(cause, sizeof header);
  if (!coder.at_end()) return fault("its coded part is longer or shorter than what it says", bytes.size());
  if (atlas_words > 0) {
    appearance.atlas_size = header.atlas_size;
    appearance.texels_per_step = header.texels_per_step;
    appearance.atlas.resize(atlas_words);
    std::memcpy(appearance.atlas.data(), bytes.data() + bytes.size() - sizeof(std::uint32_t) * atlas_words,
                sizeof(std::uint32_t) * atlas_words);
  }
  return bvh;
}

}  // namespace zc
