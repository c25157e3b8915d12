// SPDX-License-Identifier: GPL-3.0-or-later
// EXT_meshopt_compression: buffer views that meshoptimizer has packed.
#include <meshoptimizer.h>

#include <limits>
#include <nlohmann/json.hpp>

#include "baker/import/gltf/gltf_file.h"
#include "baker/import/shared/json_text.h"

namespace zc {
namespace {

using nlohmann::json;

// What a byte of a stream can stand for at most: a group of 16 equal bytes takes two bits.
constexpr std::uint64_t kMaxExpansion = 1024;

struct PackedView {
  std::span<const std::byte> bytes;
  std::uint64_t stride = 0;
  std::uint64_t count = 0;
  std::string mode;
  std::string filter = "NONE";
};

Result<PackedView> read_packed_view(const json& extension, std::uint64_t view_bytes, const std::string& where,
                                    const GltfFile& file) {
  const auto number = [&](const char* key) {
    const json* member = find_member(extension, key);
    return member != nullptr ? as_unsigned(*member) : std::nullopt;
  };
  const auto word = [&](const char* key, std::string& text) {
    const json* member = find_member(extension, key);
    if (member != nullptr && member->is_string()) text = member->get<std::string>();
  };
  const auto buffer = number("buffer");
  const auto length = number("byteLength");
  const auto stride = number("byteStride");
  const auto count = number("count");
  const std::uint64_t offset = number("byteOffset").value_or(0);
  if (!buffer || !length || !stride || !count)
    return file.error(where + " lacks its buffer, byteLength, byteStride or count");
  if (*buffer >= file.buffers.size()) return file.error(where + " names buffer " + std::to_string(*buffer));
  const auto& bytes = file.buffers[*buffer];
  if (offset > bytes.size() || *length > bytes.size() - offset)
    return file.error(where + " reaches past the " + std::to_string(bytes.size()) + " bytes of buffer " +
                      std::to_string(*buffer));
  PackedView packed{bytes.subspan(offset, *length), *stride, *count, {}};
  word("mode", packed.mode);
  word("filter", packed.filter);
  if (packed.stride == 0 || packed.stride > 256 || packed.count > std::numeric_limits<std::uint32_t>::max() ||
      packed.count * packed.stride > view_bytes)
    return file.error(where + " unpacks to more than its bufferView contains");
  if (packed.count * packed.stride > kMaxExpansion * *length)
    return file.error(where + " of " + std::to_string(*length) + " bytes declares " +
                      std::to_string(packed.count * packed.stride) + " bytes");
  return packed;
}

Result<std::vector<std::byte>> unpack(const PackedView& packed, const std::string& where, const GltfFile& file) {
  std::vector<std::byte> out(packed.count * packed.stride);
  const auto* stream = reinterpret_cast<const unsigned char*>(packed.bytes.data());
  int failure = 0;
  if (packed.mode == "ATTRIBUTES") {
    if (packed.stride % 4 != 0) return file.error(where + " has a byteStride that is no multiple of 4");
    failure = meshopt_decodeVertexBuffer(out.data(), packed.count, packed.stride, stream, packed.bytes.size());
  } else if (packed.mode == "TRIANGLES" || packed.mode == "INDICES") {
    if (packed.stride != 2 && packed.stride != 4) return file.error(where + " has indices of neither 2 nor 4 bytes");
    if (packed.mode == "TRIANGLES" && packed.count % 3 != 0)
      return file.error(where + " has a count that is no multiple of 3");
    failure = packed.mode == "TRIANGLES"
                  ? meshopt_decodeIndexBuffer(out.data(), packed.count, packed.stride, stream, packed.bytes.size())
                  : meshopt_decodeIndexSequence(out.data(), packed.count, packed.stride, stream, packed.bytes.size());
  } else {
    return file.error(where + " has mode '" + one_line(packed.mode) + "'");
  }
  if (failure != 0) return file.error(where + " is a damaged stream");
  if (packed.filter == "NONE") return out;
  if (packed.mode != "ATTRIBUTES") return file.error(where + " filters indices");
  if (packed.filter == "OCTAHEDRAL" && (packed.stride == 4 || packed.stride == 8))
    meshopt_decodeFilterOct(out.data(), packed.count, packed.stride);
  else if (packed.filter == "QUATERNION" && packed.stride == 8)
    meshopt_decodeFilterQuat(out.data(), packed.count, packed.stride);
  else if (packed.filter == "EXPONENTIAL")
    meshopt_decodeFilterExp(out.data(), packed.count, packed.stride);
  else
    return file.error(where + " has filter '" + one_line(packed.filter) + "' at a byteStride of " +
                      std::to_string(packed.stride));
  return out;
}

}  // namespace

Status decode_meshopt_views(const json& document, GltfFile& file) {
  const json* views = find_member(document, "bufferViews");
  if (views == nullptr) return {};
  for (std::size_t i = 0; i < views->size(); ++i) {
    const json* extensions = find_member((*views)[i], "extensions");
    const json* extension = extensions != nullptr ? find_member(*extensions, "EXT_meshopt_compression") : nullptr;
    if (extension == nullptr) continue;
    const std::string where = "bufferView " + std::to_string(i) + " EXT_meshopt_compression";
    const json* length = find_member((*views)[i], "byteLength");  // checked when the views were
    ZC_ASSIGN(const PackedView packed, read_packed_view(*extension, *as_unsigned(*length), where, file));
    ZC_ASSIGN(std::vector<std::byte> bytes, unpack(packed, where, file));
    file.owned.push_back(std::move(bytes));
    file.decoded_views[static_cast<int>(i)] = file.owned.back();
  }
  return {};
}

}  // namespace zc
