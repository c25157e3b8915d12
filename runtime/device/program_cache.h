// SPDX-License-Identifier: Apache-2.0
// Compute programs by shader and specialisation: a setting that was there before is not compiled again, and one that a
// shader does not use does not compile it anew.
// Owns its programs. Borrows the device and the code. Threads: one at a time. Fails as Program does.
#pragma once

#include <map>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "runtime/device/program.h"

namespace zc {

class ProgramCache {
 public:
  explicit ProgramCache(Device& device) : device_(device) {}

  // Lives as long as the cache. name: for messages.
  Result<Program*> compute(const char* name, std::span<const std::uint32_t> spirv, const Constants& constants);
  // Programs that were made so far.
  [[nodiscard]] std::size_t size() const { return programs_.size(); }

 private:
  using Key = std::pair<const std::uint32_t*, Constants>;

  Device& device_;
  std::map<const std::uint32_t*, std::vector<std::uint32_t>> constant_ids_;
  std::map<Key, std::unique_ptr<Program>> programs_;
};

}  // namespace zc
