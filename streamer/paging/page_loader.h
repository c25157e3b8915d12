// SPDX-License-Identifier: Apache-2.0
// Reads, verifies, decodes and assembles one node's page. Untrusted input: hashes first, then every count.
// Threads: any, as far as the source allows.
#pragma once

#include <chrono>
#include <cstdint>
#include <vector>

#include "base/result.h"
#include "streamer/source/source.h"
#include "streamer/world_format/index_view.h"

namespace zc {

// The files that a node's page is made of.
[[nodiscard]] std::vector<WantedFile> page_files(const NodeRecord& node);

// From an AsyncRead of page_files(). materials: that the world has. `read_at`: set to when both files had been read, or
// the reading failed.
Result<std::vector<std::uint32_t>> load_page(AsyncRead& files, const NodeRecord& node, std::size_t materials,
                                             std::chrono::steady_clock::time_point* read_at = nullptr);

// At once, for callers that have nothing else to do: what may pass (kTransient) is tried again, with_retries.
Result<std::vector<std::uint32_t>> load_page(Source& source, const IndexView& index, std::uint32_t node);

// Both files' bytes.
[[nodiscard]] std::uint64_t compressed_bytes(const NodeRecord& node);
// What load_page takes beside them and the page it returns.
[[nodiscard]] std::uint64_t scratch_bytes(const NodeRecord& node);

}  // namespace zc
