// SPDX-License-Identifier: Apache-2.0
#include "tests/unit/streamer/tiny_world.h"

#include <draco/compression/decode.h>
#include <draco/compression/expert_encode.h>
#include <xxhash.h>

#include <algorithm>
#include <cstring>
#include <nlohmann/json.hpp>
#include <random>

#include "base/check.h"
#include "base/file.h"
#include "shaders/shared/page_node.h"
#include "streamer/world_format/cluster_tables.h"

namespace zc::test {
namespace {

using Json = nlohmann::json;
using Vertex = std::array<std::uint16_t, 3>;

constexpr std::uint32_t kLeafExtent = 1U << 14U;  // 64 m in lattice steps of 2^-8 m

struct Part {
  std::vector<Vertex> vertices;
  std::vector<std::array<std::uint32_t, 3>> triangles;
};

Part make_ground(std::uint32_t grid, std::uint32_t extent, std::mt19937& random) {
  Part part;
  for (std::uint32_t y = 0; y <= grid; ++y)
    for (std::uint32_t x = 0; x <= grid; ++x)
      part.vertices.push_back({static_cast<std::uint16_t>(x * extent / grid),
                               static_cast<std::uint16_t>(y * extent / grid),
                               static_cast<std::uint16_t>(random() % (extent / 8 + 1))});
  for (std::uint32_t y = 0; y < grid; ++y)
    for (std::uint32_t x = 0; x < grid; ++x) {
      const std::uint32_t a = y * (grid + 1) + x;
      part.triangles.push_back({a, a + 1, a + grid + 2});
      part.triangles.push_back({a, a + grid + 2, a + grid + 1});
    }
  return part;
}

Part make_soup(std::uint32_t count, std::uint32_t extent, std::mt19937& random) {
  Part part;
  for (std::uint32_t t = 0; t < count; ++t) {
    for (int k = 0; k < 3; ++k)
      part.vertices.push_back({static_cast<std::uint16_t>(random() % (extent + 1)),
                               static_cast<std::uint16_t>(random() % (extent + 1)),
                               static_cast<std::uint16_t>(random() % (extent + 1))});
    part.triangles.push_back({3 * t, 3 * t + 1, 3 * t + 2});
  }
  return part;
}

struct Stream {
  std::vector<std::byte> bytes;
  std::uint32_t points = 0;
  std::uint32_t faces = 0;
  std::uint32_t attribute = 0;
};

// Of four colours, in runs of triangles.
void add_colors(draco::Mesh& mesh, std::uint32_t corners) {
  draco::GeometryAttribute color;
  color.Init(draco::GeometryAttribute::COLOR, nullptr, 3, draco::DT_UINT8, true, 3, 0);
  draco::PointAttribute& values = *mesh.attribute(mesh.AddAttribute(color, false, 4));
  for (std::uint32_t i = 0; i < 4; ++i) {
    const std::array<std::uint8_t, 3> rgb = {static_cast<std::uint8_t>(60 * i), static_cast<std::uint8_t>(200 - 7 * i),
                                             static_cast<std::uint8_t>(i * i)};
    values.SetAttributeValue(draco::AttributeValueIndex(i), rgb.data());
  }
  for (std::uint32_t c = 0; c < corners; ++c)
    values.SetPointMapEntry(draco::PointIndex(c), draco::AttributeValueIndex(c / 9 * 7 % 4));
}

Stream encode(const Part& part, TinyStream kind) {
  const auto corners = static_cast<std::uint32_t>(3 * part.triangles.size());
  draco::Mesh mesh;
  mesh.set_num_points(corners);
  mesh.SetNumFaces(part.triangles.size());
  for (std::uint32_t i = 0; i < part.triangles.size(); ++i)
    mesh.SetFace(draco::FaceIndex(i),
                 {draco::PointIndex(3 * i), draco::PointIndex(3 * i + 1), draco::PointIndex(3 * i + 2)});
  if (kind == TinyStream::kColored) add_colors(mesh, corners);
  draco::GeometryAttribute position;
  position.Init(draco::GeometryAttribute::POSITION, nullptr, 3, draco::DT_UINT16, false, 6, 0);
  draco::PointAttribute& values =
      *mesh.attribute(mesh.AddAttribute(position, false, static_cast<std::uint32_t>(part.vertices.size())));
  for (std::uint32_t i = 0; i < part.vertices.size(); ++i)
    values.SetAttributeValue(draco::AttributeValueIndex(i), part.vertices[i].data());
  for (std::uint32_t c = 0; c < corners; ++c)
    values.SetPointMapEntry(draco::PointIndex(c), draco::AttributeValueIndex(part.triangles[c / 3][c % 3]));
  mesh.DeduplicatePointIds();
  draco::ExpertEncoder encoder(mesh);
  encoder.SetSpeedOptions(3, 3);
  encoder.SetEncodingMethod(kind == TinyStream::kSequential ? draco::MESH_SEQUENTIAL_ENCODING
                                                            : draco::MESH_EDGEBREAKER_ENCODING);
  if (kind == TinyStream::kColored) ZC_CHECK(encoder.SetAttributePredictionScheme(0, draco::PREDICTION_NONE).ok());
  draco::EncoderBuffer buffer;
  ZC_CHECK(encoder.EncodeToBuffer(&buffer).ok());
  draco::DecoderBuffer input;
  input.Init(buffer.data(), buffer.size());
  draco::Decoder decoder;
  auto decoded = decoder.DecodeMeshFromBuffer(&input);
  ZC_CHECK(decoded.ok());
  Stream stream;
  stream.bytes.resize(buffer.size());
  std::memcpy(stream.bytes.data(), buffer.data(), buffer.size());
  stream.points = decoded.value()->num_points();
  stream.faces = decoded.value()->num_faces();
  stream.attribute = decoded.value()->GetNamedAttribute(draco::GeometryAttribute::POSITION)->unique_id();
  return stream;
}

void append_word(std::vector<std::byte>& out, std::uint32_t value) {
  const auto* bytes = reinterpret_cast<const std::byte*>(&value);
  out.insert(out.end(), bytes, bytes + sizeof value);
}

std::vector<std::byte> make_glb(const std::vector<Stream>& streams) {
  Json json = {{"asset", {{"version", "2.0"}}}};
  std::vector<std::byte> bin;
  for (std::size_t i = 0; i < streams.size(); ++i) {
    const Stream& stream = streams[i];
    json["accessors"].push_back({{"componentType", 5123}, {"count", stream.points}, {"type", "VEC3"}});
    json["bufferViews"].push_back({{"buffer", 0}, {"byteOffset", bin.size()}, {"byteLength", stream.bytes.size()}});
    json["meshes"][0]["primitives"].push_back(
        {{"attributes", {{"POSITION", i}}},
         {"extensions",
          {{"KHR_draco_mesh_compression", {{"bufferView", i}, {"attributes", {{"POSITION", stream.attribute}}}}}}}});
    bin.insert(bin.end(), stream.bytes.begin(), stream.bytes.end());
    bin.resize((bin.size() + 3) / 4 * 4);
  }
  std::string text = json.dump();
  text.resize((text.size() + 3) / 4 * 4, ' ');
  std::vector<std::byte> out;
  for (const std::size_t word :
       {std::size_t{0x46546C67}, std::size_t{2}, 28 + text.size() + bin.size(), text.size(), std::size_t{0x4E4F534A}})
    append_word(out, static_cast<std::uint32_t>(word));
  const auto* chars = reinterpret_cast<const std::byte*>(text.data());
  out.insert(out.end(), chars, chars + text.size());
  append_word(out, static_cast<std::uint32_t>(bin.size()));
  append_word(out, 0x004E4942);
  out.insert(out.end(), bin.begin(), bin.end());
  return out;
}

// Halves three times a node, at the median of the longest axis.
class MedianBuilder {
 public:
  MedianBuilder(const ZoneMesh& mesh, const NodeRecord& record) : mesh_(mesh), record_(record) {
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) order_.push_back(t);
  }

  BvhFile run() {
    bvh_.nodes.emplace_back();
    bvh_.clusters.push_back(0);
    fill(0, 0, static_cast<std::uint32_t>(order_.size()), 1);
    return std::move(bvh_);
  }

 private:
  static constexpr std::uint32_t kLeaf = 4;

  void halve(std::uint32_t first, std::uint32_t end, int times, std::vector<std::array<std::uint32_t, 2>>& parts) {
    if (times == 0 || end - first <= kLeaf) {
      parts.push_back({first, end});
      return;
    }
    const NodeBox box = box_of(first, end);
    std::size_t axis = 0;
    for (std::size_t a = 1; a < 3; ++a)
      if (box.max[a] - box.min[a] > box.max[axis] - box.min[axis]) axis = a;
    const auto key = [&](std::uint32_t t) {
      std::uint32_t sum = 0;
      for (const std::uint32_t v : mesh_.triangles[t]) sum += mesh_.vertices[v][axis];
      return std::pair(sum, t);
    };
    std::sort(order_.begin() + first, order_.begin() + end,
              [&](std::uint32_t a, std::uint32_t b) { return key(a) < key(b); });
    const std::uint32_t middle = (first + end) / 2;
    halve(first, middle, times - 1, parts);
    halve(middle, end, times - 1, parts);
  }

  void fill(std::uint32_t index, std::uint32_t first, std::uint32_t end, std::uint32_t depth) {
    bvh_.depth = std::max(bvh_.depth, depth);
    std::vector<std::array<std::uint32_t, 2>> parts;
    halve(first, end, 3, parts);
    std::array<NodeBox, gpu::kNodeWidth> boxes;
    for (std::size_t i = 0; i < parts.size(); ++i) boxes[i] = box_of(parts[i][0], parts[i][1]);
    gpu::PageNode node = pack_boxes(boxes);
    std::vector<std::uint32_t> leaves;
    std::vector<std::size_t> inner;
    for (std::uint32_t i = 0; i < parts.size(); ++i) {
      const auto [a, b] = parts[i];
      if (b - a > kLeaf) {
        node.exponents_masks |= 1U << (16 + i);
        inner.push_back(i);
      } else {
        node.exponents_masks |= 1U << (24 + i);
        node.leaf_counts |= (b - a) << (4 * i);
        leaves.insert(leaves.end(), order_.begin() + a, order_.begin() + b);
      }
    }
    if (!leaves.empty()) append(node, leaves);
    const auto child = static_cast<std::uint32_t>(bvh_.nodes.size());
    if (!inner.empty()) node.child_offset = child;
    bvh_.nodes[index] = node;
    bvh_.nodes.resize(bvh_.nodes.size() + inner.size());
    for (std::uint32_t i = 0; i < inner.size(); ++i) fill(child + i, parts[inner[i]][0], parts[inner[i]][1], depth + 1);
  }

  bool try_add(const std::vector<std::uint32_t>& triangles) {
    for (const std::uint32_t t : triangles)
      for (const std::uint32_t v : mesh_.triangles[t])
        if (!vertices_.add(mesh_.vertices[v])) return false;
    return true;
  }

  void append(gpu::PageNode& node, const std::vector<std::uint32_t>& triangles) {
    if (!try_add(triangles)) {
      bvh_.clusters.push_back(static_cast<std::uint32_t>(bvh_.order.size()));
      vertices_.clear();
      ZC_CHECK(try_add(triangles));
    }
    node.triangle_offset = static_cast<std::uint32_t>(bvh_.order.size());
    node.cluster_offset = static_cast<std::uint32_t>(bvh_.clusters.size()) - 1;
    bvh_.order.insert(bvh_.order.end(), triangles.begin(), triangles.end());
  }

  [[nodiscard]] NodeBox box_of(std::uint32_t first, std::uint32_t end) const {
    NodeBox box;
    for (std::uint32_t i = first; i < end; ++i)
      for (const std::uint32_t v : mesh_.triangles[order_[i]]) {
        std::array<std::int32_t, 3> p{};
        for (std::size_t a = 0; a < 3; ++a)
          p[a] = record_.origin[a] + (std::int32_t{mesh_.vertices[v][a]} << record_.step_shift);
        box.add({p, p});
      }
    return box;
  }

  const ZoneMesh& mesh_;
  const NodeRecord& record_;
  std::vector<std::uint32_t> order_;
  ClusterVertices vertices_;
  BvhFile bvh_;
};

void add_files(TinyWorld& world, NodeRecord& record, TinyZone zone) {
  world.files[node_file(record, "glb")] = std::move(zone.glb);
  world.files[node_file(record, "zbvh")] = std::move(zone.bvh);
}

}  // namespace

BvhFile build_median_bvh(const ZoneMesh& mesh, const NodeRecord& record) { return MedianBuilder(mesh, record).run(); }

TinyZone make_tiny_zone(std::uint32_t grid, std::uint32_t soup, std::uint32_t extent, std::uint32_t seed,
                        NodeRecord& record, TinyStream kind) {
  std::mt19937 random(seed);
  std::vector<Stream> streams;
  streams.push_back(encode(make_ground(grid, extent, random), kind));
  if (soup > 0) streams.push_back(encode(make_soup(soup, extent, random), kind));
  TinyZone zone;
  zone.glb = make_glb(streams);
  record.triangle_count = 0;
  record.vertex_count = 0;
  record.primitive_count = static_cast<std::uint32_t>(streams.size());
  for (const Stream& stream : streams) {
    record.triangle_count += stream.faces;
    record.vertex_count += stream.points;
  }
  record.glb_bytes = zone.glb.size();
  record.glb_xxh3 = XXH3_64bits(zone.glb.data(), zone.glb.size());
  Result<ZoneMesh> mesh = decode_zone_glb(zone.glb, record, "tiny");
  if (!mesh.ok()) std::fprintf(stderr, "%s\n", mesh.error().describe().c_str());
  ZC_CHECK(mesh.ok());
  for (std::uint16_t i = 0; i < streams.size(); ++i) mesh->materials.insert(mesh->materials.end(), streams[i].faces, i);
  const BvhFile bvh = build_median_bvh(*mesh, record);
  record.bvh_node_count = static_cast<std::uint32_t>(bvh.nodes.size());
  record.bvh_depth = bvh.depth;
  record.reference_count = static_cast<std::uint32_t>(bvh.order.size());
  zone.bvh = encode_bvh_file(bvh, *mesh, record).bytes;
  record.bvh_bytes = zone.bvh.size();
  record.bvh_xxh3 = XXH3_64bits(zone.bvh.data(), zone.bvh.size());
  record.scratch_bytes = decode_scratch_bytes(zone.glb, record);
  const auto page = assemble_page(*mesh, bvh, record, 2, "tiny");
  ZC_CHECK(page.ok());
  record.page_bytes = static_cast<std::uint32_t>(4 * page->size());
  return zone;
}

TinyWorld make_tiny_world(const TinyWorldOptions& options) {
  TinyWorld world;
  world.index.materials.resize(2);
  world.index.crs = "EPSG:25832";
  const std::uint32_t top_shift = options.levels - 1;
  const auto anchor = static_cast<std::int64_t>(kTinyOrigin_m * 256);
  world.index.header.anchor = {anchor, anchor, 0};
  const auto extent = static_cast<std::int32_t>(kLeafExtent << top_shift);
  world.index.header.bounds_max = {extent, extent, extent};

  std::mt19937 random(options.seed);
  const auto add = [&](std::int32_t parent, std::uint32_t depth, std::uint32_t x, std::uint32_t y,
                       std::uint32_t flags) {
    NodeRecord node;
    node.parent = parent;
    node.depth = depth;
    node.cell_x = x;
    node.cell_y = y;
    node.flags = flags;
    node.step_shift = top_shift - depth;
    const std::uint32_t size = kLeafExtent << node.step_shift;
    node.origin = {static_cast<std::int32_t>(x * size), static_cast<std::int32_t>(y * size), 0};
    for (std::size_t a = 0; a < 3; ++a) {
      node.bounds_min[a] = node.origin[a];
      node.bounds_max[a] = node.origin[a] + static_cast<std::int32_t>(size);
    }
    const bool detail = node.is_detail();
    node.error_max_m = detail ? 0.0F : 0.25F * static_cast<float>(1U << node.step_shift);
    node.error_mean_m = node.error_max_m / 4;
    const std::uint32_t grid = (options.grid + static_cast<std::uint32_t>(random() % 4)) * (detail ? 2 : 1);
    add_files(world, node, make_tiny_zone(grid, options.soup, kLeafExtent, static_cast<std::uint32_t>(random()), node));
    world.index.nodes.push_back(node);
  };
  add(-1, 0, 0, 0, 0);
  for (std::uint32_t n = 0; n < world.index.nodes.size(); ++n) {
    const NodeRecord parent = world.index.nodes[n];
    if (parent.is_detail()) continue;
    const auto first = static_cast<std::uint32_t>(world.index.nodes.size());
    if (parent.depth + 1 < options.levels) {
      for (std::uint32_t c = 0; c < 4; ++c)
        add(static_cast<std::int32_t>(n), parent.depth + 1, 2 * parent.cell_x + c % 2, 2 * parent.cell_y + c / 2, 0);
    } else if (options.detail) {
      add(static_cast<std::int32_t>(n), parent.depth, parent.cell_x, parent.cell_y, kNodeDetail);
    } else {
      continue;
    }
    world.index.nodes[n].first_child = first;
    world.index.nodes[n].child_count = static_cast<std::uint32_t>(world.index.nodes.size()) - first;
  }
  world.files[kWorldIndexName] = encode_world_index(world.index);
  return world;
}

void write_tiny_world(const TinyWorld& world, const std::filesystem::path& dir) {
  for (const auto& [name, bytes] : world.files) {
    std::filesystem::create_directories((dir / name).parent_path());
    ZC_CHECK(write_file(dir / name, bytes).ok());
  }
}

double tiny_world_size_m(const TinyWorldOptions& options) { return 64.0 * (1U << (options.levels - 1)); }

std::vector<std::uint32_t> page_of(const TinyWorld& world, std::uint32_t node) {
  const NodeRecord& record = world.index.nodes[node];
  Result<ZoneMesh> mesh = decode_zone_glb(world.files.at(node_file(record, "glb")), record, "tiny");
  ZC_CHECK(mesh.ok());
  const Result<BvhFile> bvh = decode_bvh_file(world.files.at(node_file(record, "zbvh")), *mesh, record, "tiny");
  ZC_CHECK(bvh.ok());
  Result<std::vector<std::uint32_t>> page =
      assemble_page(*mesh, *bvh, record, static_cast<std::uint32_t>(world.index.materials.size()), "tiny");
  ZC_CHECK(page.ok());
  return *page;
}

Result<std::vector<std::byte>> MemorySource::read(const std::string& name, std::uint64_t bytes) {
  ZC_ASSIGN(std::vector<std::byte> data, read_all(name, UINT64_MAX));
  if (data.size() != bytes) return Error{ErrorCode::kFormat, "wrong size", name};
  return data;
}

Result<std::vector<std::byte>> MemorySource::read_all(const std::string& name, std::uint64_t limit_bytes) {
  const std::lock_guard lock(mutex_);
  const auto found = files_.find(name);
  if (found == files_.end()) return Error{ErrorCode::kIo, "no such file", name};
  if (found->second.size() > limit_bytes) return Error{ErrorCode::kFormat, "too large", name};
  return found->second;
}

void MemorySource::flip_byte(const std::string& name, std::size_t at) {
  const std::lock_guard lock(mutex_);
  files_.at(name).at(at) ^= std::byte{0x40};
}

void MemorySource::remove(const std::string& name) {
  const std::lock_guard lock(mutex_);
  files_.erase(name);
}

void MemorySource::restore(const std::string& name, std::vector<std::byte> bytes) {
  const std::lock_guard lock(mutex_);
  files_[name] = std::move(bytes);
}

}  // namespace zc::test
