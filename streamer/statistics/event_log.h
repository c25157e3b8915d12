// SPDX-License-Identifier: Apache-2.0
// What the streamer did, in order, as one hash: two replays did the same exactly when their hashes are equal.
// Each event is three little-endian 32-bit words (frame, kind, node) fed to XXH3-64. Threads: one.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

namespace zc {

enum class EventKind : std::uint32_t {
  kIssue = 1,
  kRetry,
  kCancel,
  kResident,
  kFail,
  kEvict,
  kCompact,
};

class EventLog {
 public:
  EventLog();
  ~EventLog();
  EventLog(const EventLog&) = delete;
  EventLog& operator=(const EventLog&) = delete;

  void record(std::uint32_t frame, EventKind kind, std::uint32_t node);
  [[nodiscard]] std::string hash() const;  // 16 hexadecimal digits

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace zc
