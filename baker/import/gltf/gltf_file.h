// SPDX-License-Identifier: GPL-3.0-or-later
// A glTF or GLB file with its buffers, every container length and buffer view checked against the bytes that exist.
// tinygltf parses nodes, meshes, accessors and materials; buffers and images stay out of its hands.
// Owns all bytes. Untrusted input. Thread-safe for const use.
#pragma once

#define TINYGLTF_NO_FS
#define TINYGLTF_NO_STB_IMAGE
#define TINYGLTF_NO_STB_IMAGE_WRITE
#define TINYGLTF_NO_EXTERNAL_IMAGE
#include <tiny_gltf.h>

#include <cstddef>
#include <filesystem>
#include <glm/vec3.hpp>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>
#include <vector>

#include "baker/import/shared/input_files.h"
#include "base/result.h"

namespace zc {

struct GltfImage {
  std::string uri;                  // external; or empty
  int buffer_view = -1;             // embedded bytes; or negative
  std::vector<std::byte> embedded;  // of a data URI
};

struct GltfFile {
  std::string path;
  tinygltf::Model model;            // its buffers and images are empty: use the members below
  glm::dvec3 center{0};             // that positions are relative to, z up
  std::uint64_t stored_bytes = 0;   // of the JSON and the buffers, as they are stored
  std::uint64_t morph_targets = 0;  // primitives that have any, left out of the model
  std::vector<GltfImage> images;
  std::vector<std::span<const std::byte>> buffers;
  std::map<int, std::span<const std::byte>> decoded_views;  // of EXT_meshopt_compression
  std::vector<std::vector<std::byte>> owned;                // what all of these point into

  [[nodiscard]] Error error(std::string message) const { return {ErrorCode::kFormat, std::move(message), path}; }
  // Fails when the index is out of range. Ranges were checked when the file was read.
  [[nodiscard]] Result<std::span<const std::byte>> view(int buffer_view) const;
};

// `bytes` is the model in the file at `path`, GLB or JSON; external buffers lie within `root`. Fails on lengths that
// disagree with the file and on required extensions that are not handled, named.
Result<GltfFile> read_gltf(std::vector<std::byte> bytes, const std::string& path, const std::filesystem::path& root,
                           const InputFiles& files);

// `document` is the file's JSON, checked as far as its buffer views. Fills in decoded_views.
Status decode_meshopt_views(const nlohmann::json& document, GltfFile& file);

}  // namespace zc
