// SPDX-License-Identifier: Apache-2.0
// Our own pages and kernels: a page a zone, the top level over all of them, traced as a frame's rays are; or the same
// trees without compression. Bytes are those of the pages and the top level; tracing reads nothing else. Build time is
// that of pages on the CPU's threads, of the top level, and of taking the compression off.
// Borrows the device. Threads: as the device; the page builder is called from several at once.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "replay/bench/engines/trace_engine.h"
#include "runtime/device/device.h"
#include "runtime/tracing/trace_variant.h"
#include "streamer/world_format/bvh_page.h"

namespace zc::bench {

struct ZonePage {
  std::vector<std::uint32_t> words;
  std::vector<std::uint32_t> order;  // by position in the page: triangle of the mesh
};

// Makes the page of a zone. Given by the composition root, because builders are the baker's.
using PageBuilder = std::function<Result<ZonePage>(const ZoneMesh& mesh, NodeRecord& node)>;

struct ZonecastOptions {
  std::string name;
  TraceVariant variant;
  bool plain = false;  // the same trees without compression (plain_layout.h)
  bool any_hit = false;
};

// Fails, when it traces, where the variant does not fit the device or the depth of the pages.
std::unique_ptr<TraceEngine> make_zonecast_engine(Device& device, ZonecastOptions options, PageBuilder builder,
                                                  unsigned threads);

}  // namespace zc::bench
