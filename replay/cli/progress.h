// SPDX-License-Identifier: Apache-2.0
// A progress bar on standard error: drawn on a terminal, silent in a pipe.
// Threads: update may be called from any.
#pragma once

#include <mutex>
#include <string>
#include <string_view>

namespace zc {

class Progress {
 public:
  Progress();
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;
  void update(double fraction, std::string_view stage);

 private:
  bool terminal_;
  std::mutex mutex_;
  std::string shown_;
};

}  // namespace zc
