// SPDX-License-Identifier: Apache-2.0
// Progress on standard error: a bar on a terminal, and for commands that have the options lines elsewhere.
// Threads: update may be called from any.
#pragma once

#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdint>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>

#include "replay/session/progress_lines.h"

namespace zc {

enum class ProgressMode : std::uint8_t { kAuto, kBar, kLines, kNone };

struct ProgressOption {
  ProgressMode mode = ProgressMode::kAuto;
  bool quiet = false;  // warnings, errors, and the report where --json asks for it
};

// --progress and --quiet.
void add_progress_options(CLI::App& command, ProgressOption& option);

class Progress {
 public:
  // A bar on a terminal, nothing elsewhere.
  Progress();
  // kAuto: lines where no terminal is, once the work takes long. Of quiet ones the log is warnings and errors from now
  // on.
  explicit Progress(const ProgressOption& option);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  void update(double fraction, std::string_view stage, const ProgressCount& count = {});
  // The work is through, and did not fail.
  void finish();

 private:
  [[nodiscard]] double now_s() const;

  bool bar_;
  std::optional<ProgressLines> lines_;
  std::chrono::steady_clock::time_point began_ = std::chrono::steady_clock::now();
  std::mutex mutex_;
  std::string shown_;
};

}  // namespace zc
