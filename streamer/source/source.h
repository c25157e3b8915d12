// SPDX-License-Identifier: Apache-2.0
// Where a world's files come from: a directory, an archive, a server, anything that reads named files by size.
// Owns: nothing that callers see · threads: every method may be called from several threads at once · untrusted input:
// names with ".." or absolute names are refused, sizes are checked before memory is taken.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"

namespace zc {

// A file as the index knows it.
struct WantedFile {
  std::string name;
  std::uint64_t bytes = 0;
  std::uint64_t xxh3 = 0;
};

// Fails when a name is none of a file within a world.
Status check_name(const std::string& name);

// Fails when these are not the bytes wanted.
Status check_wanted(std::span<const std::byte> bytes, const WantedFile& file);

// Files on their way. An AsyncRead that goes cancels what has not come and frees their memory.
// Threads: wait() on one, cancel() from any.
class AsyncRead {
 public:
  AsyncRead() = default;
  AsyncRead(const AsyncRead&) = delete;
  AsyncRead& operator=(const AsyncRead&) = delete;
  virtual ~AsyncRead() = default;

  // Blocks until the i-th file is there; its size and its hash are as wanted. The bytes stay as long as the AsyncRead.
  virtual Result<std::span<const std::byte>> wait(std::size_t i) = 0;
  // wait() returns soon, with an error if the bytes had not come.
  virtual void cancel() {}
};

// A file that is read piece by piece. Threads: any, at once.
class SourceFile {
 public:
  SourceFile() = default;
  SourceFile(const SourceFile&) = delete;
  SourceFile& operator=(const SourceFile&) = delete;
  virtual ~SourceFile() = default;

  [[nodiscard]] virtual std::uint64_t size_bytes() const = 0;
  // Fills `out` from there on; fails when the file ends before.
  virtual Status read(std::uint64_t offset_bytes, std::span<std::byte> out) const = 0;
};

// What reading from a source takes in memory.
struct SourceCosts {
  std::uint64_t held_bytes = 0;  // from its opening to its end, beside what is read
  bool whole_files = true;       // open() reads the whole file
};

// What a source behind a network did; all zero for any other.
struct SourceStatistics {
  std::uint64_t requests = 0;
  std::uint64_t failed = 0;          // of them
  std::uint64_t bytes_received = 0;  // without headers
  std::uint64_t not_modified = 0;    // answers that a cached copy is still right
  std::uint64_t cache_hits = 0;      // files for which nothing was asked
  std::uint64_t cache_damaged = 0;   // entries thrown away
};

class Source {
 public:
  virtual ~Source() = default;

  // The whole file `name`, which must be exactly `bytes` long: a file of another size is an error, not a short buffer.
  virtual Result<std::vector<std::byte>> read(const std::string& name, std::uint64_t bytes) = 0;

  // The whole file `name`, whatever its size up to limit_bytes.
  virtual Result<std::vector<std::byte>> read_all(const std::string& name, std::uint64_t limit_bytes) = 0;

  // The same file, to be read piece by piece while the source is there; of a source behind a network, as here, it is
  // in memory as a whole.
  virtual Result<std::unique_ptr<SourceFile>> open(const std::string& name, std::uint64_t limit_bytes);

  // Files that are read together. A source behind a network has begun when this returns, and does not repeat what
  // fails; here, each is read when it is waited for.
  virtual std::unique_ptr<AsyncRead> begin(std::vector<WantedFile> files);

  [[nodiscard]] virtual SourceStatistics statistics() const { return {}; }

  [[nodiscard]] virtual SourceCosts costs() const { return {}; }
};

// Of sources behind a network.
struct SourceOptions {
  std::filesystem::path cache;                  // folder for what was read, made when it is not there; empty: none
  std::uint64_t cache_bytes = 1ULL << 30U;      // most that the cache may take
  double timeout_s = 10;                        // to connect, and of silence
  std::uint64_t held_bytes_most = 1ULL << 30U;  // most that a source may keep in memory
};

// Whether `place` is an address of the web (http://, https://) and not a path.
[[nodiscard]] bool is_url(std::string_view place);

// Fails when `dir` is not a directory.
Result<std::unique_ptr<Source>> open_directory_source(const std::filesystem::path& dir);

}  // namespace zc
