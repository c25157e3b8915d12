// SPDX-License-Identifier: Apache-2.0
#include "replay/cli/progress.h"

#include <algorithm>
#include <array>
#include <cstdio>

#include "base/platform.h"

namespace zc {

Progress::Progress() : terminal_(standard_error_is_terminal()) {}

Progress::~Progress() {
  if (!shown_.empty()) std::fputs("\r\033[K", stderr);
}

void Progress::update(double fraction, std::string_view stage) {
  if (!terminal_) return;
  constexpr std::size_t width = 32;
  fraction = std::clamp(fraction, 0.0, 1.0);
  const auto full = static_cast<std::size_t>(fraction * width);
  std::array<char, 16> percent{};
  std::snprintf(percent.data(), percent.size(), " %3.0f %% ", fraction * 100);
  std::string line(1, '[');
  line.append(full, '#').append(width - full, '.').append("]").append(percent.data()).append(stage);
  const std::lock_guard lock(mutex_);
  if (line == shown_) return;
  std::fprintf(stderr, "\r%s\033[K", line.c_str());
  std::fflush(stderr);
  shown_ = std::move(line);
}

}  // namespace zc
