// SPDX-License-Identifier: Apache-2.0
#include "streamer/statistics/event_log.h"

#define XXH_STATIC_LINKING_ONLY  // the state by value
#include <xxhash.h>

#include <array>
#include <cstdio>

namespace zc {

struct EventLog::State {
  XXH3_state_t hash;
};

EventLog::EventLog() : state_(std::make_unique<State>()) { XXH3_64bits_reset(&state_->hash); }
EventLog::~EventLog() = default;

void EventLog::record(std::uint32_t frame, EventKind kind, std::uint32_t node) {
  const std::array<std::uint32_t, 3> event = {frame, static_cast<std::uint32_t>(kind), node};
  XXH3_64bits_update(&state_->hash, event.data(), sizeof event);
}

std::string EventLog::hash() const {
  std::array<char, 17> text = {};
  std::snprintf(text.data(), text.size(), "%016llx",
                static_cast<unsigned long long>(XXH3_64bits_digest(&state_->hash)));
  return text.data();
}

}  // namespace zc
