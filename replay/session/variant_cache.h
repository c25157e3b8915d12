// SPDX-License-Identifier: Apache-2.0
// What self-measurements chose, kept from one replay to the next: one small JSON file with an entry a device. An entry
// holds for the device's name, its driver, this version of zonecast and its page format.
// Untrusted input: an entry or a file that is damaged, foreign or out of date is as good as none.
// Threads: any; of replays that write at once the last one's file stays, whole.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "runtime/tracing/trace_variant.h"

namespace zc {

struct VariantKey {
  std::string device, driver;
};

// trace_variants.json in $XDG_CACHE_HOME/zonecast, else in ~/.cache/zonecast; empty where the environment names
// neither.
std::filesystem::path variant_cache_file();

std::optional<TraceVariant> read_cached_variant(const std::filesystem::path& file, const VariantKey& key);
// Takes the place of what was known of the device. Fails when the file cannot be written.
Status write_cached_variant(const std::filesystem::path& file, const VariantKey& key, const TraceVariant& variant);

}  // namespace zc
