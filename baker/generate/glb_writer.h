// SPDX-License-Identifier: GPL-3.0-or-later
// Gathers objects and writes them as one plain glTF 2.0 binary: a node and a mesh per object, a primitive per material,
// float positions and u32 indices, y up. Normals are left out: surfaces are flat and viewers derive them.
// Owns the bytes gathered so far. Not thread-safe.
// Source: glTF 2.0 specification, sections 3.6 (binary data) and 4 (GLB).
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "baker/generate/mesh_builder.h"
#include "base/result.h"

namespace zc::generate {

class GlbWriter {
 public:
  // An object without triangles is left out.
  void add(const MeshBuilder& mesh);

  [[nodiscard]] std::uint64_t triangles() const { return triangles_; }
  [[nodiscard]] std::uint64_t objects() const { return objects_; }

  // The whole file; the writer is spent. Fails when a GLB, whose lengths are 32 bits, cannot hold it.
  Result<std::vector<std::byte>> finish();

 private:
  std::vector<float> positions_;
  std::vector<std::uint32_t> indices_;
  std::string nodes_, meshes_, accessors_;  // JSON, comma-separated
  std::uint64_t accessor_count_ = 0;
  std::uint64_t triangles_ = 0;
  std::uint64_t objects_ = 0;
};

}  // namespace zc::generate
