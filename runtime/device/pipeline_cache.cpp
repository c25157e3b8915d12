// SPDX-License-Identifier: Apache-2.0
#include "runtime/device/pipeline_cache.h"

#include <array>
#include <cstdint>
#include <cstring>
#include <span>
#include <vector>

#include "base/file.h"
#include "runtime/device/device.h"

namespace zc {
namespace {

constexpr std::uint64_t kFileLimit = 256U << 20U;

// The driver recognises its own data by their header. Damage behind the header is not for a driver to find, so the file
// begins with a hash of all that follows: FNV-1a.
std::uint64_t hash_of(std::span<const std::byte> bytes) {
  std::uint64_t hash = 0xCBF29CE484222325U;
  for (const std::byte b : bytes) hash = (hash ^ static_cast<std::uint64_t>(b)) * 0x100000001B3U;
  return hash;
}

}  // namespace

Result<VkPipelineCache> open_pipeline_cache(VkDevice device, const std::filesystem::path& file) {
  std::vector<std::byte> kept;
  if (!file.empty()) {
    if (Result<std::vector<std::byte>> read = read_file(file, kFileLimit); read) kept = *std::move(read);
  }
  std::uint64_t hash = 0;
  std::span<const std::byte> data;
  if (kept.size() > sizeof hash) {
    std::memcpy(&hash, kept.data(), sizeof hash);
    data = std::span(kept).subspan(sizeof hash);
    if (hash_of(data) != hash) data = {};
  }
  VkPipelineCacheCreateInfo info{VK_STRUCTURE_TYPE_PIPELINE_CACHE_CREATE_INFO};
  info.initialDataSize = data.size();
  info.pInitialData = data.data();
  VkPipelineCache cache = VK_NULL_HANDLE;
  ZC_VK(vkCreatePipelineCache(device, &info, nullptr, &cache));
  return cache;
}

void keep_pipeline_cache(VkDevice device, VkPipelineCache cache, const std::filesystem::path& file) {
  std::size_t size = 0;
  if (file.empty() || cache == VK_NULL_HANDLE) return;
  if (vkGetPipelineCacheData(device, cache, &size, nullptr) != VK_SUCCESS || size == 0) return;
  std::vector<std::byte> data(size);
  if (vkGetPipelineCacheData(device, cache, &size, data.data()) != VK_SUCCESS) return;
  data.resize(size);
  const std::uint64_t hash = hash_of(data);
  const std::array<std::span<const std::byte>, 2> parts = {std::as_bytes(std::span(&hash, 1)), data};
  if (make_folder(file.parent_path()).ok()) static_cast<void>(write_file_parts(file, parts).ok());
}

}  // namespace zc
