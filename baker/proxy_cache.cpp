// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/proxy_cache.h"

#include <xxhash.h>

#include <bit>
#include <cmath>
#include <cstring>
#include <memory>
#include <set>
#include <type_traits>

#include "base/file.h"

namespace zc {
namespace {

// One more whenever simplification, measuring or this format change: what they returned before is stale then.
constexpr std::uint32_t kVersion = 2;
constexpr std::array<char, 4> kMagic = {'Z', 'P', 'C', '1'};
constexpr std::uint64_t kBytesMost = std::uint64_t{1} << 34U;
constexpr std::uint32_t kStepShiftMost = 14;  // 2^30 steps in 2^16

class Hasher {
 public:
  Hasher() { XXH3_128bits_reset(state_.get()); }
  template <class T>
  requires std::has_unique_object_representations_v<T> || std::is_floating_point_v<T> Hasher& add(const T& value) {
    XXH3_128bits_update(state_.get(), &value, sizeof value);
    return *this;
  }
  template <class T>
  requires std::has_unique_object_representations_v<T> Hasher& add(std::span<const T> values) {
    add(std::uint64_t{values.size()});
    if (!values.empty()) XXH3_128bits_update(state_.get(), values.data(), values.size_bytes());
    return *this;
  }
  [[nodiscard]] ProxyKey key() const {
    const XXH128_hash_t hash = XXH3_128bits_digest(state_.get());
    return {hash.high64, hash.low64};
  }

 private:
  struct Free {
    void operator()(XXH3_state_t* state) const { XXH3_freeState(state); }
  };
  std::unique_ptr<XXH3_state_t, Free> state_{XXH3_createState()};
};

void add_place(Hasher& hash, const SimplifyContext& context, const Zone& zone) {
  const CellGrid& grid = *context.grid;
  hash.add(kVersion).add(context.step_m).add(context.error_m).add(context.leaf_triangles);
  hash.add(grid.root_log2).add(grid.min_cell_log2).add(grid.overhang).add(grid.height);
  hash.add(zone.depth).add(zone.cell_x).add(zone.cell_y).add(static_cast<std::uint32_t>(zone.parent < 0));
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
  std::uint32_t stored = 0;  // 0: simplification found none worth storing
  std::uint32_t vertex_count = 0;
  std::uint32_t face_count = 0;
};

std::vector<std::byte> encode_entry(const std::optional<Proxy>& proxy) {
  EntryHeader header;
  if (proxy) {
    const SurfaceError& e = proxy->error;
    header.numbers = {e.max_m, e.mean_m, e.normal_deviation_deg, e.color_error, e.appearance_m, proxy->tolerance};
    header.step_shift = proxy->step_shift;
    header.stored = 1;
    header.vertex_count = static_cast<std::uint32_t>(proxy->mesh.vertices.size());
    header.face_count = static_cast<std::uint32_t>(proxy->mesh.faces.size());
  }
  std::vector<std::byte> out(sizeof header);
  std::memcpy(out.data(), &header, sizeof header);
  if (!proxy) return out;
  const auto vertices = std::as_bytes(std::span(proxy->mesh.vertices));
  out.insert(out.end(), vertices.begin(), vertices.end());
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
  if (header.face_count == 0 || header.step_shift > kStepShiftMost) return std::nullopt;
  for (const double number : header.numbers)
    if (!std::isfinite(number) || number < 0) return std::nullopt;
  Proxy proxy;
  const auto& n = header.numbers;
  proxy.error = {n[0], n[1], n[2], n[3], n[4]};
  proxy.tolerance = n[5];
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
  }
  if (step_shift_for_box(bounds_of(proxy.mesh)) > header.step_shift) return std::nullopt;
  return std::optional<Proxy>(std::move(proxy));
}

struct FileHeader {
  std::array<char, 4> magic = kMagic;
  std::uint32_t version = kVersion;
  std::uint64_t xxh3 = 0;  // of all that follows
};

struct EntryPlace {
  ProxyKey key = {};
  std::uint64_t bytes = 0;
};

}  // namespace

ProxyKey leaf_key(const SimplifyContext& context, const Zone& zone) {
  Hasher hash;
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
    hash.add(m).add(context.looks[m]).add(material.base_color.r).add(material.base_color.g).add(material.base_color.b);
    hash.add(material.roughness).add(material.metallic);
  }
  return hash.key();
}

ProxyKey inner_key(const SimplifyContext& context, const Zone& zone, std::span<const ProxyKey> children,
                   std::span<const ProxyKey> leaves) {
  Hasher hash;
  add_place(hash, context, zone);
  return hash.add(children).add(leaves).key();
}

void ProxyCache::read(const std::filesystem::path& file, std::size_t material_count) {
  const std::lock_guard lock(mutex_);
  material_count_ = material_count;
  const Result<std::vector<std::byte>> bytes = read_file(file, kBytesMost);
  FileHeader header;
  if (!bytes || bytes->size() < sizeof header) return;
  std::memcpy(&header, bytes->data(), sizeof header);
  std::span<const std::byte> rest = std::span(*bytes).subspan(sizeof header);
  if (header.magic != kMagic || header.version != kVersion || header.xxh3 != XXH3_64bits(rest.data(), rest.size()))
    return;
  for (EntryPlace place; rest.size() >= sizeof place;) {
    std::memcpy(&place, rest.data(), sizeof place);
    rest = rest.subspan(sizeof place);
    if (place.bytes > rest.size()) return;
    const auto entry = rest.first(place.bytes);
    entries_[place.key].bytes.assign(entry.begin(), entry.end());
    rest = rest.subspan(place.bytes);
  }
}

std::optional<std::optional<Proxy>> ProxyCache::find(const ProxyKey& key) {
  const std::lock_guard lock(mutex_);
  const auto entry = entries_.find(key);
  if (entry == entries_.end()) return std::nullopt;
  std::optional<std::optional<Proxy>> proxy = decode_entry(entry->second.bytes, material_count_);
  if (!proxy) return std::nullopt;
  entry->second.used = true;
  ++found_;
  return proxy;
}

void ProxyCache::add(const ProxyKey& key, const std::optional<Proxy>& proxy) {
  std::vector<std::byte> bytes = encode_entry(proxy);
  const std::lock_guard lock(mutex_);
  entries_[key] = {std::move(bytes), true};
  ++added_;
}

std::vector<std::byte> ProxyCache::encode() const {
  const std::lock_guard lock(mutex_);
  FileHeader header;
  std::vector<std::byte> out(sizeof header);
  for (const auto& [key, entry] : entries_) {
    if (!entry.used) continue;
    const EntryPlace place = {key, entry.bytes.size()};
    const auto bytes = std::as_bytes(std::span(&place, 1));
    out.insert(out.end(), bytes.begin(), bytes.end());
    out.insert(out.end(), entry.bytes.begin(), entry.bytes.end());
  }
  header.xxh3 = XXH3_64bits(out.data() + sizeof header, out.size() - sizeof header);
  std::memcpy(out.data(), &header, sizeof header);
  return out;
}

}  // namespace zc
