// SPDX-License-Identifier: Apache-2.0
// A folder that keeps what was read from a network, up to a size: the entries that were not used for longest go first.
// An entry is a file of its own, NAME.zccache by the hash of its key, written whole or not at all, with its key and a
// hash of its bytes inside; one that is damaged, cut or another key's is thrown away. Nothing else in the folder is
// touched. Threads: every method from any; several processes may share a folder. Fails never: what cannot be kept is
// read again. Untrusted input: entries are checked before use.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/result.h"

namespace zc {

class DiskCache {
 public:
  // Makes the folder when it is not there. Fails when that cannot be read or written.
  static Result<std::unique_ptr<DiskCache>> open(const std::filesystem::path& folder, std::uint64_t limit_bytes);

  // Whether there is an entry: cheap, and no promise that it is whole.
  [[nodiscard]] bool has(const std::string& key) const;
  // Marks it as used. Nothing when it is not there, larger than limit_bytes, or damaged.
  [[nodiscard]] std::optional<std::vector<std::byte>> get(const std::string& key, std::uint64_t limit_bytes);
  void put(const std::string& key, std::span<const std::byte> bytes);
  void remove(const std::string& key);

  [[nodiscard]] std::uint64_t damaged() const;  // entries thrown away so far

 private:
  DiskCache(std::filesystem::path folder, std::uint64_t limit_bytes);
  [[nodiscard]] std::filesystem::path place_of(const std::string& key) const;
  void discard(const std::filesystem::path& place);
  void shrink(std::uint64_t coming);  // under the lock

  const std::filesystem::path folder_;
  const std::uint64_t limit_bytes_;
  mutable std::mutex mutex_;
  std::uint64_t held_bytes_ = 0;  // at least, by this process's account
  std::uint64_t damaged_ = 0;
};

}  // namespace zc
