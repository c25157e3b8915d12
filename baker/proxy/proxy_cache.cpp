// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/proxy/proxy_cache.h"

#include <cmath>
#include <cstring>
#include <set>

namespace zc {
namespace {

// One more whenever simplification, measuring or an entry's form change: what they returned before is stale then.
constexpr std::uint32_t kVersion = 12;
constexpr std::uint32_t kStepShiftLimit = 14;  // 2^30 steps in 2^16

void add_place(CacheKeyHasher& hash, const SimplifyContext& context, const Zone& zone) {
  const CellGrid& grid = *context.grid;
  hash.add(kVersion).add(context.step_m).add(context.error_m).add(context.leaf_triangles);
  hash.add(grid.root_log2).add(grid.min_cell_log2).add(grid.overhang).add(grid.height);
  hash.add(zone.depth).add(zone.cell_x).add(zone.cell_y).add(static_cast<std::uint32_t>(zone.parent < 0));
  hash.add(zone.moved[0]).add(zone.moved[1]);
}

constexpr std::size_t kFaceBytes = 18;

void append_face(const LatticeFace& face, std::vector<std::byte>& out) {
  const std::array<std::uint16_t, 3> rest = {face.material, static_cast<std::uint16_t>(face.ground), 0};
  const std::size_t at = out.size();
  out.resize(at + sizeof face.v + sizeof rest);
  std::memcpy(out.data() + at, face.v.data(), sizeof face.v);
  std::memcpy(out.data() + at + sizeof face.v, rest.data(), sizeof rest);
}

// A proxy's numbers, before its vertices and faces.
struct EntryHeader {
  std::array<double, 6> numbers = {};  // SurfaceError's in order, tolerance
  std::uint32_t step_shift = 0;
  std::uint32_t stored = 0;  // 0: simplification found none worth storing; 2: it ended at its bound of work
  std::uint32_t vertex_count = 0;
  std::uint32_t face_count = 0;
};

std::vector<std::byte> encode_entry(const std::optional<Proxy>& proxy) {
  EntryHeader header;
  if (proxy) {
    const SurfaceError& e = proxy->error;
    header.numbers = {e.max_m, e.mean_m, e.normal_deviation_deg, e.color_error, e.appearance_m, proxy->tolerance};
    header.step_shift = proxy->step_shift;
    header.stored = proxy->is_bounded ? 2 : 1;
    header.vertex_count = static_cast<std::uint32_t>(proxy->mesh.vertices.size());
    header.face_count = static_cast<std::uint32_t>(proxy->mesh.faces.size());
  }
  const std::size_t vertex_bytes = header.vertex_count * sizeof(LatticePoint);
  std::vector<std::byte> out(sizeof header + vertex_bytes);
  std::memcpy(out.data(), &header, sizeof header);
  if (!proxy) return out;
  if (vertex_bytes > 0) std::memcpy(out.data() + sizeof header, proxy->mesh.vertices.data(), vertex_bytes);
  for (const LatticeFace& face : proxy->mesh.faces) append_face(face, out);
  return out;
}

// What encode_entry wrote, checked as simplification would have made it; nothing where it is not.
std::optional<std::optional<Proxy>> decode_entry(std::span<const std::byte> bytes, std::size_t material_count) {
  EntryHeader header;
  if (bytes.size() < sizeof header) return std::nullopt;
  std::memcpy(&header, bytes.data(), sizeof header);
  bytes = bytes.subspan(sizeof header);
  const std::uint64_t vertex_bytes = std::uint64_t{header.vertex_count} * sizeof(LatticePoint);
  if (bytes.size() != vertex_bytes + std::uint64_t{header.face_count} * kFaceBytes) return std::nullopt;
  if (header.stored == 0) return std::optional<Proxy>();
  if (header.stored > 2 || header.face_count == 0 || header.step_shift > kStepShiftLimit) return std::nullopt;
  // Neither steps nor metres, which are no shorter, go beyond the lattice.
  for (const double number : header.numbers)
    if (!(number >= 0 && number <= 2.0 * kLatticeExtentMax)) return std::nullopt;
  Proxy proxy;
  const auto& n = header.numbers;
  proxy.error = {n[0], n[1], n[2], n[3], n[4]};
  proxy.tolerance = n[5];
  proxy.is_bounded = header.stored == 2;
  proxy.step_shift = header.step_shift;
  proxy.mesh.vertices.resize(header.vertex_count);
  if (vertex_bytes > 0) std::memcpy(proxy.mesh.vertices.data(), bytes.data(), vertex_bytes);
  const std::int32_t below_step = (1 << header.step_shift) - 1;
  for (const LatticePoint& p : proxy.mesh.vertices)
    for (const std::int32_t c : p)
      if ((c & below_step) != 0 || std::abs(std::int64_t{c}) > kLatticeExtentMax) return std::nullopt;
  proxy.mesh.faces.resize(header.face_count);
  for (std::size_t i = 0; i < proxy.mesh.faces.size(); ++i) {
    LatticeFace& face = proxy.mesh.faces[i];
    const std::byte* at = bytes.data() + vertex_bytes + i * kFaceBytes;
    std::array<std::uint16_t, 3> rest{};
    std::memcpy(face.v.data(), at, sizeof face.v);
    std::memcpy(rest.data(), at + sizeof face.v, sizeof rest);
    face.material = rest[0];
    face.ground = rest[1] != 0;
    for (const std::uint32_t v : face.v)
      if (v >= header.vertex_count) return std::nullopt;
    if (face.material >= material_count) return std::nullopt;
    const auto& at_vertex = proxy.mesh.vertices;
    if (is_degenerate(at_vertex[face.v[0]], at_vertex[face.v[1]], at_vertex[face.v[2]])) return std::nullopt;
  }
  if (step_shift_for_box(bounds_of(proxy.mesh)) > header.step_shift) return std::nullopt;
  return std::optional<Proxy>(std::move(proxy));
}

}  // namespace

CacheKey leaf_key(const SimplifyContext& context, const Zone& zone) {
  CacheKeyHasher hash;
  add_place(hash, context, zone);
  std::vector<std::byte> faces;
  std::set<std::uint16_t> used;
  for (const LatticeFace& face : zone.detail.faces) {
    append_face(face, faces);
    used.insert(face.material);
  }
  hash.add(std::span<const LatticePoint>(zone.detail.vertices)).add(std::span<const std::byte>(faces));
  for (const std::uint16_t m : used) {
    const Material& material = context.materials[m];
    hash.add(m)
        .add(context.appearances[m])
        .add(material.base_color.r)
        .add(material.base_color.g)
        .add(material.base_color.b);
    hash.add(material.roughness).add(material.metallic);
  }
  return hash.key();
}

CacheKey inner_key(const SimplifyContext& context, const Zone& zone, std::span<const CacheKey> children,
                   std::span<const CacheKey> leaves) {
  CacheKeyHasher hash;
  add_place(hash, context, zone);
  return hash.add(children).add(leaves).key();
}

std::optional<std::optional<Proxy>> ProxyCache::find(const CacheKey& key) {
  const auto bytes = store_.find(key);
  if (!bytes) return std::nullopt;
  std::optional<std::optional<Proxy>> proxy = decode_entry(*bytes, material_count_);
  if (proxy) ++found_;
  return proxy;
}

void ProxyCache::add(const CacheKey& key, const std::optional<Proxy>& proxy) {
  store_.add(key, encode_entry(proxy));
  ++added_;
}

}  // namespace zc
