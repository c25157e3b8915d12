// SPDX-License-Identifier: GPL-3.0-or-later
// GLB: Khronos glTF 2.0, section 4.4.
#include "baker/import/gltf/gltf_file.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <filesystem>
#include <initializer_list>
#include <limits>
#include <nlohmann/json.hpp>
#include <string_view>

#include "baker/import/shared/json_text.h"
#include "baker/import/shared/uri.h"

namespace zc {
namespace {

using nlohmann::json;

constexpr std::uint32_t kGlbMagic = 0x46546C67;   // "glTF"
constexpr std::uint32_t kChunkJson = 0x4E4F534A;  // "JSON"
constexpr std::uint32_t kChunkBin = 0x004E4942;   // "BIN\0"
constexpr std::uint64_t kMaxBufferBytes = std::uint64_t{1} << 34U;

// Extensions that leave positions, indices and node transforms as they are, besides the three that are followed.
constexpr std::array<std::string_view, 17> kHandled = {"EXT_mesh_gpu_instancing",
                                                       "EXT_meshopt_compression",
                                                       "KHR_draco_mesh_compression",
                                                       "KHR_mesh_quantization",
                                                       "KHR_texture_transform",
                                                       "KHR_texture_basisu",
                                                       "EXT_texture_webp",
                                                       "EXT_texture_avif",
                                                       "KHR_lights_punctual",
                                                       "KHR_xmp_json_ld",
                                                       "EXT_mesh_features",
                                                       "EXT_structural_metadata",
                                                       "EXT_instance_features",
                                                       "KHR_animation_pointer",
                                                       "MSFT_texture_dds",
                                                       "EXT_lights_image_based",
                                                       "CESIUM_RTC"};

std::uint32_t word(std::span<const std::byte> bytes, std::size_t at) {
  std::uint32_t value = 0;
  std::memcpy(&value, bytes.data() + at, sizeof value);
  return value;
}

// A version that is not read, and what to do about it.
Error wrong_version(const std::string& version, const std::string& path, std::int64_t at = -1) {
  std::string advice;
  if (version.starts_with("0.") || version.starts_with('1')) {
    const bool is_tile = std::filesystem::path(path).extension() == ".b3dm";
    advice = is_tile ? "; convert the tileset, for example with 3d-tiles-tools from npm: 3d-tiles-tools upgrade "
                       "-i tileset.json -o new"
                     : "; convert it, for example with gltf-pipeline from npm: gltf-pipeline -i old.gltf -o new.glb";
  }
  return {ErrorCode::kUnsupported, "glTF version " + version + ", only 2.0 is read" + advice, path, at};
}

// glTF 1.0 need not name its version, but its lists are objects whose members have names.
bool has_named_lists(const json& document) {
  const auto is_object = [&](const char* key) {
    const json* member = find_member(document, key);
    return member != nullptr && member->is_object();
  };
  return is_object("meshes") || is_object("accessors") || is_object("buffers");
}

Status check_version(const json& document, const std::string& path) {
  const json* asset = find_member(document, "asset");
  const json* version = asset != nullptr ? find_member(*asset, "version") : nullptr;
  if (version == nullptr) {
    if (has_named_lists(document)) return wrong_version("1.0", path);
    return Error{ErrorCode::kFormat, "glTF has no asset.version", path};
  }
  if (version->is_number() && version->get<double>() < 2) return wrong_version(version->dump(), path);
  if (!version->is_string()) return Error{ErrorCode::kFormat, "asset.version of the glTF is not text", path};
  const std::string& text = version->get_ref<const std::string&>();
  if (!text.starts_with("2.")) return wrong_version(one_line(text), path);
  return {};
}

struct Chunks {
  std::string_view json;
  std::span<const std::byte> bin;
  std::int64_t json_offset = 0;
};

Result<Chunks> split_glb(std::span<const std::byte> bytes, const std::string& path) {
  const auto fault = [&](std::string message, std::uint64_t at) {
    return Error{ErrorCode::kFormat, std::move(message), path, static_cast<std::int64_t>(at)};
  };
  if (bytes.size() < 12) return fault("GLB header is cut short", bytes.size());
  // A container of version 1 contains glTF 1.0.
  if (word(bytes, 4) == 1) return wrong_version("1.0", path, 4);
  if (word(bytes, 4) != 2)
    return Error{ErrorCode::kUnsupported, "GLB version " + std::to_string(word(bytes, 4)) + ", only 2 is read", path,
                 4};
  const std::uint64_t length = word(bytes, 8);
  if (length > bytes.size())
    return fault("file ends early: GLB declares " + std::to_string(length) + " bytes; get it again", bytes.size());
  Chunks chunks;
  std::uint64_t at = 12;
  bool has_json = false;
  for (int index = 0; at < length && index < 2; ++index) {
    if (length - at < 8) return fault("GLB chunk header is cut short", at);
    const std::uint64_t size = word(bytes, at);
    const std::uint32_t type = word(bytes, at + 4);
    if (size > length - at - 8)
      return fault("GLB chunk of " + std::to_string(size) + " bytes reaches past the end of the file", at);
    const auto body = bytes.subspan(at + 8, size);
    if (index == 0) {
      if (type != kChunkJson) return fault("the first GLB chunk is not JSON", at + 4);
      chunks.json = {reinterpret_cast<const char*>(body.data()), body.size()};
      chunks.json_offset = static_cast<std::int64_t>(at) + 8;
      has_json = true;
    } else if (type == kChunkBin) {
      chunks.bin = body;
    }
    at += 8 + size;
  }
  if (!has_json) return fault("GLB has no JSON chunk", at);
  return chunks;
}

bool decode_data_uri(const std::string& uri, std::vector<std::byte>& out) {
  std::vector<unsigned char> data;
  std::string mime;
  if (!tinygltf::DecodeDataURI(&data, mime, uri, 0, false)) return false;
  out.resize(data.size());
  std::ranges::transform(data, out.begin(), [](unsigned char c) { return std::byte{c}; });
  return true;
}

// The array member `key`, empty when absent; every element an object.
Result<json> object_array(const json& document, const char* key, const std::string& path) {
  const json* member = find_member(document, key);
  if (member == nullptr) return json::array();
  if (!member->is_array() || !std::all_of(member->begin(), member->end(), [](const json& e) { return e.is_object(); }))
    return Error{ErrorCode::kFormat, std::string(key) + " is not an array of objects", path};
  return *member;
}

Result<std::uint64_t> unsigned_member(const json& object, const char* key, std::optional<std::uint64_t> fallback,
                                      const std::string& where, const std::string& path) {
  const json* member = find_member(object, key);
  if (member == nullptr && fallback) return *fallback;
  const auto value = member != nullptr ? as_unsigned(*member) : std::nullopt;
  if (!value) return Error{ErrorCode::kFormat, where + " has no valid " + key, path};
  return *value;
}

Status check_required(const json& document, const std::string& path) {
  const json* required = find_member(document, "extensionsRequired");
  if (required == nullptr) return {};
  if (!required->is_array()) return Error{ErrorCode::kFormat, "extensionsRequired is not an array", path};
  for (const json& name : *required) {
    if (!name.is_string()) return Error{ErrorCode::kFormat, "extensionsRequired contains something but names", path};
    const std::string& text = name.get_ref<const std::string&>();
    if (std::find(kHandled.begin(), kHandled.end(), text) == kHandled.end() && !text.starts_with("KHR_materials_"))
      return Error{ErrorCode::kUnsupported, "requires the extension " + one_line(text) + ", which is not handled",
                   path};
  }
  return {};
}

Status load_buffers(const json& document, std::span<const std::byte> bin, bool is_glb,
                    const std::filesystem::path& root, const InputFiles& files, GltfFile& file) {
  ZC_ASSIGN(const json buffers, object_array(document, "buffers", file.path));
  for (std::size_t i = 0; i < buffers.size(); ++i) {
    const std::string where = "buffer " + std::to_string(i);
    ZC_ASSIGN(const std::uint64_t length, unsigned_member(buffers[i], "byteLength", {}, where, file.path));
    const json* uri = find_member(buffers[i], "uri");
    std::span<const std::byte> bytes;
    if (uri == nullptr) {
      // A buffer without bytes is legal (a fallback of a compression extension); only views into it are faults.
      if (is_glb && i == 0) bytes = bin;
      if (is_glb && i == 0 && length > bin.size())
        return file.error(where + " declares " + std::to_string(length) + " bytes, the BIN chunk has " +
                          std::to_string(bin.size()));
    } else {
      if (!uri->is_string()) return file.error(where + " has a uri that is not text");
      const std::string& text = uri->get_ref<const std::string&>();
      std::vector<std::byte> loaded;
      if (tinygltf::IsDataURI(text)) {
        if (!decode_data_uri(text, loaded)) return file.error(where + " has a damaged data URI");
      } else {
        ZC_ASSIGN(const std::filesystem::path beside, file_of_uri(text, file.path, root));
        ZC_ASSIGN(loaded, files.read(beside, kMaxBufferBytes));
      }
      if (loaded.size() < length)
        return file.error(where + " declares " + std::to_string(length) + " bytes, " + std::to_string(loaded.size()) +
                          " exist");
      file.owned.push_back(std::move(loaded));
      bytes = file.owned.back();  // the heap block stays where it is when `owned` grows
    }
    file.buffers.push_back(bytes.first(std::min<std::size_t>(bytes.size(), length)));
  }
  return {};
}

Status check_views(const json& document, const GltfFile& file) {
  ZC_ASSIGN(const json views, object_array(document, "bufferViews", file.path));
  for (std::size_t i = 0; i < views.size(); ++i) {
    const std::string where = "bufferView " + std::to_string(i);
    ZC_ASSIGN(const std::uint64_t buffer, unsigned_member(views[i], "buffer", {}, where, file.path));
    ZC_ASSIGN(const std::uint64_t offset, unsigned_member(views[i], "byteOffset", 0, where, file.path));
    ZC_ASSIGN(const std::uint64_t length, unsigned_member(views[i], "byteLength", {}, where, file.path));
    if (buffer >= file.buffers.size()) return file.error(where + " names buffer " + std::to_string(buffer));
    // Views into a buffer without bytes are left to whoever asks for them.
    const std::uint64_t have = file.buffers[buffer].size();
    if (have > 0 && (offset > have || length > have - offset))
      return file.error(where + " reaches past the " + std::to_string(have) + " bytes of buffer " +
                        std::to_string(buffer));
  }
  return {};
}

Status read_images(const json& document, GltfFile& file) {
  ZC_ASSIGN(const json images, object_array(document, "images", file.path));
  for (const json& image : images) {
    GltfImage entry;
    const json* view = find_member(image, "bufferView");
    const json* uri = find_member(image, "uri");
    if (view != nullptr && as_unsigned(*view) && *as_unsigned(*view) < std::numeric_limits<int>::max()) {
      entry.buffer_view = view->get<int>();
    } else if (uri != nullptr && uri->is_string()) {
      const std::string& text = uri->get_ref<const std::string&>();
      if (!tinygltf::IsDataURI(text)) {
        entry.uri = text;
      } else if (!decode_data_uri(text, entry.embedded)) {
        entry.embedded.clear();
      }
    }
    file.images.push_back(std::move(entry));
  }
  return {};
}

bool is_index(const json& value) {
  return as_unsigned(value) && *as_unsigned(value) <= std::numeric_limits<int>::max();
}
bool is_numbers(const json& value) {
  return value.is_array() && std::all_of(value.begin(), value.end(), [](const json& e) { return e.is_number(); });
}

// tinygltf takes a member of the wrong type for one that is not there.
Status check_members(const json& object, const std::string& where, const GltfFile& file,
                     std::initializer_list<const char*> indices, std::initializer_list<const char*> numbers,
                     std::initializer_list<const char*> lists) {
  const auto check = [&](std::initializer_list<const char*> keys, bool (*is_right)(const json&),
                         const char* wanted) -> Status {
    for (const char* key : keys)
      if (const auto member = object.find(key); member != object.end() && !is_right(*member))
        return file.error(where + " has a " + key + " that is no " + wanted);
    return {};
  };
  ZC_TRY(check(indices, is_index, "index"));
  ZC_TRY(check(
      numbers, [](const json& e) { return e.is_number(); }, "number"));
  return check(lists, is_numbers, "array of numbers");
}

Status check_types(const json& document, const GltfFile& file) {
  ZC_TRY(check_members(document, "the file", file, {"scene"}, {}, {}));
  const auto each = [&](const char* key, const auto& check) -> Status {
    ZC_ASSIGN(const json list, object_array(document, key, file.path));
    for (std::size_t i = 0; i < list.size(); ++i)
      ZC_TRY(check(list[i], std::string(key) + "[" + std::to_string(i) + "]"));
    return {};
  };
  ZC_TRY(each("nodes", [&](const json& node, const std::string& where) {
    return check_members(node, where, file, {"mesh", "skin"}, {},
                         {"matrix", "rotation", "scale", "translation", "children"});
  }));
  ZC_TRY(each("textures", [&](const json& texture, const std::string& where) {
    return check_members(texture, where, file, {"source", "sampler"}, {}, {});
  }));
  const auto check_mesh = [&](const json& mesh, const std::string& where) -> Status {
    ZC_ASSIGN(const json primitives, object_array(mesh, "primitives", file.path));
    for (const json& primitive : primitives)
      ZC_TRY(check_members(primitive, "a primitive of " + where, file, {"indices", "material", "mode"}, {}, {}));
    return {};
  };
  ZC_TRY(each("meshes", check_mesh));
  return each("materials", [&](const json& material, const std::string& where) -> Status {
    const json* pbr = find_member(material, "pbrMetallicRoughness");
    if (pbr == nullptr) return {};
    ZC_TRY(check_members(*pbr, where, file, {}, {"metallicFactor", "roughnessFactor"}, {"baseColorFactor"}));
    const json* texture = find_member(*pbr, "baseColorTexture");
    return texture != nullptr ? check_members(*texture, where, file, {"index", "texCoord"}, {}, {}) : Status{};
  });
}

// CESIUM_RTC: a centre that positions are relative to, given in the frame that z is up in.
Status read_center(const json& document, GltfFile& file) {
  const json* extensions = find_member(document, "extensions");
  const json* relative = extensions != nullptr ? find_member(*extensions, "CESIUM_RTC") : nullptr;
  if (relative == nullptr) return {};
  const json* center = find_member(*relative, "center");
  const auto numbers = center != nullptr ? as_numbers(*center, 3) : std::nullopt;
  if (!numbers) return file.error("CESIUM_RTC has no center of three numbers");
  file.center = {(*numbers)[0], (*numbers)[1], (*numbers)[2]};
  return {};
}

// What tinygltf shall see. An indexed Draco primitive has accessors without a view, which it refuses: the index
// accessor goes, since the Draco stream contains the indices.
json reduced(const json& document, GltfFile& file) {
  json kept = json::object();
  for (const char* key :
       {"asset", "accessors", "bufferViews", "materials", "meshes", "nodes", "samplers", "scene", "scenes", "textures"})
    if (const json* member = find_member(document, key); member != nullptr) kept[key] = *member;
  if (!kept.contains("meshes") || !kept["meshes"].is_array()) return kept;
  for (json& mesh : kept["meshes"]) {
    if (!mesh.is_object() || !mesh.contains("primitives") || !mesh["primitives"].is_array()) continue;
    for (json& primitive : mesh["primitives"]) {
      if (!primitive.is_object()) continue;
      file.morph_targets += primitive.erase("targets");
      const json* extensions = find_member(primitive, "extensions");
      if (extensions != nullptr && find_member(*extensions, "KHR_draco_mesh_compression") != nullptr)
        primitive.erase("indices");
    }
  }
  return kept;
}

}  // namespace

Result<std::span<const std::byte>> GltfFile::view(int buffer_view) const {
  if (buffer_view < 0 || static_cast<std::size_t>(buffer_view) >= model.bufferViews.size())
    return error("bufferView " + std::to_string(buffer_view) + " does not exist");
  if (const auto decoded = decoded_views.find(buffer_view); decoded != decoded_views.end()) return decoded->second;
  const tinygltf::BufferView& entry = model.bufferViews[static_cast<std::size_t>(buffer_view)];
  const auto index = static_cast<std::size_t>(entry.buffer);
  if (entry.buffer < 0 || index >= buffers.size() || entry.byteOffset > buffers[index].size() ||
      entry.byteLength > buffers[index].size() - entry.byteOffset)
    return error("bufferView " + std::to_string(buffer_view) + " has no bytes behind it");
  return buffers[index].subspan(entry.byteOffset, entry.byteLength);
}

Result<GltfFile> read_gltf(std::vector<std::byte> bytes, const std::string& path, const std::filesystem::path& root,
                           const InputFiles& files) {
  GltfFile file;
  file.path = path;
  file.owned.push_back(std::move(bytes));
  const std::span<const std::byte> all = file.owned.front();
  const bool is_glb = all.size() >= 4 && word(all, 0) == kGlbMagic;
  Chunks chunks;
  if (is_glb) {
    ZC_ASSIGN(chunks, split_glb(all, path));
  } else {
    chunks.json = {reinterpret_cast<const char*>(all.data()), all.size()};
  }
  std::string text;
  {
    ZC_ASSIGN(const json document, parse_json(chunks.json, path, chunks.json_offset));
    ZC_TRY(check_version(document, path));
    ZC_TRY(check_required(document, path));
    ZC_TRY(check_types(document, file));
    ZC_TRY(load_buffers(document, chunks.bin, is_glb, root, files, file));
    file.stored_bytes = chunks.json.size();
    for (const auto& buffer : file.buffers) file.stored_bytes += buffer.size();
    ZC_TRY(check_views(document, file));
    ZC_TRY(decode_meshopt_views(document, file));
    ZC_TRY(read_images(document, file));
    ZC_TRY(read_center(document, file));
    text = reduced(document, file).dump(-1, ' ', false, json::error_handler_t::replace);
  }
  if (text.size() > std::numeric_limits<unsigned>::max())
    return Error{ErrorCode::kUnsupported, "glTF JSON is larger than 4 GiB", path};
  tinygltf::TinyGLTF parser;
  std::string fault;
  std::string warning;
  try {
    if (!parser.LoadASCIIFromString(&file.model, &fault, &warning, text.data(), static_cast<unsigned>(text.size()), ""))
      return file.error("invalid glTF: " + one_line(fault));
    // It leaves out what it cannot parse, reports it here and returns success.
    if (!fault.empty()) return file.error("invalid glTF: " + one_line(fault));
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception& thrown) {
    return file.error("invalid glTF: " + one_line(thrown.what()));
  }
  return file;
}

}  // namespace zc
