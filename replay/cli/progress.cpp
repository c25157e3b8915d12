// SPDX-License-Identifier: Apache-2.0
#include "replay/cli/progress.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <array>
#include <cstdio>

#include "base/platform.h"
#include "replay/cli/choice_option.h"

namespace zc {
namespace {

// Nobody asked for these lines: work that takes no longer has none.
constexpr double kShortWork_s = 10;

ProgressMode mode_of(const ProgressOption& option) {
  if (option.quiet) return ProgressMode::kNone;
  if (option.mode != ProgressMode::kAuto) return option.mode;
  return standard_error_is_terminal() ? ProgressMode::kBar : ProgressMode::kAuto;
}

}  // namespace

void add_progress_options(CLI::App& command, ProgressOption& option) {
  add_choice_option<ProgressMode>(command, "--progress", option.mode,
                                  {{"auto", ProgressMode::kAuto},
                                   {"bar", ProgressMode::kBar},
                                   {"lines", ProgressMode::kLines},
                                   {"none", ProgressMode::kNone}},
                                  "On standard error; auto: a bar on a terminal, else lines once it takes 10 s",
                                  "auto");
  command.add_flag("--quiet", option.quiet, "Only warnings, errors, and the report that --json asks for");
}

Progress::Progress() : bar_(standard_error_is_terminal()) {}

Progress::Progress(const ProgressOption& option) : bar_(mode_of(option) == ProgressMode::kBar) {
  if (option.quiet) spdlog::set_level(spdlog::level::warn);
  const ProgressMode mode = mode_of(option);
  if (mode == ProgressMode::kAuto || mode == ProgressMode::kLines)
    lines_.emplace(mode == ProgressMode::kAuto ? kShortWork_s : 0);
}

Progress::~Progress() {
  if (!shown_.empty()) std::fputs("\r\033[K", stderr);
}

double Progress::now_s() const {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - began_).count();
}

void Progress::finish() {
  const std::lock_guard lock(mutex_);
  if (!lines_) return;
  for (const std::string& line : lines_->finish(now_s())) spdlog::info("{}", line);
}

void Progress::update(double fraction, std::string_view stage, const ProgressCount& count) {
  if (lines_) {
    const std::lock_guard lock(mutex_);
    for (const std::string& line : lines_->update(now_s(), fraction, stage, count)) spdlog::info("{}", line);
  }
  if (!bar_) return;
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
