// SPDX-License-Identifier: Apache-2.0
// The engines that `zonecast bench trace` knows, by name.
#pragma once

#include <memory>
#include <span>
#include <string_view>

#include "replay/bench/engines/trace_engine.h"
#include "replay/bench/engines/zonecast_engine.h"
#include "runtime/device/device.h"

namespace zc::bench {

struct EngineContext {
  Device* device = nullptr;                   // borrowed; null where no device was needed
  const PageBuilder* page_builder = nullptr;  // borrowed; null where there is none
  unsigned threads = 1;
  bool any_hit = false;  // else the closest
};

struct EngineEntry {
  std::string_view name;
  bool needs_device;
  // Empty where the engine can run; else why it cannot.
  std::string_view (*missing)(const EngineContext&);
  std::unique_ptr<TraceEngine> (*make)(const EngineContext&, std::string_view name);
};

// In the order of the table.
std::span<const EngineEntry> all_engines();

}  // namespace zc::bench
