// SPDX-License-Identifier: Apache-2.0
// Reads, verifies, decodes and assembles one node's page. Untrusted input: hashes first, then every count.
// Threads: any, as far as the source allows.
#pragma once

#include <cstdint>
#include <vector>

#include "base/result.h"
#include "streamer/source.h"
#include "streamer/world_format/world_index.h"

namespace zc {

Result<std::vector<std::uint32_t>> load_page(Source& source, const WorldIndex& index, std::uint32_t node);

// Both files' bytes.
[[nodiscard]] std::uint64_t compressed_bytes(const NodeRecord& node);
// What load_page takes beside them and the page it returns.
[[nodiscard]] std::uint64_t scratch_bytes(const NodeRecord& node);

}  // namespace zc
