// SPDX-License-Identifier: Apache-2.0
// Compiled pipelines, kept in a file from one run to the next. Untrusted input: a file that is damaged, foreign or out
// of date is as good as none. Threads: any; of programs that write at once the last one's file stays, whole.
#pragma once

#include <vulkan/vulkan.h>

#include <filesystem>

#include "base/result.h"

namespace zc {

// file: empty for a cache in memory alone.
Result<VkPipelineCache> open_pipeline_cache(VkDevice device, const std::filesystem::path& file);

// What cannot be written is compiled again next time.
void keep_pipeline_cache(VkDevice device, VkPipelineCache cache, const std::filesystem::path& file);

}  // namespace zc
