// SPDX-License-Identifier: Apache-2.0
#include "base/platform.h"

#include <malloc.h>
#include <stdlib.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <fstream>

namespace zc {
namespace {

std::uint64_t status_bytes(const std::string& key) {
  std::ifstream status("/proc/self/status");
  std::string word;
  while (status >> word) {
    if (word != key) continue;
    std::uint64_t kibibytes = 0;
    status >> kibibytes;
    return kibibytes * 1024;
  }
  return 0;
}

}  // namespace

std::uint64_t resident_set_bytes() { return status_bytes("VmRSS:"); }
std::uint64_t peak_resident_set_bytes() { return status_bytes("VmHWM:"); }
void reset_peak_resident_set() { std::ofstream("/proc/self/clear_refs") << "5"; }

void return_freed_memory() {
  mallopt(M_MMAP_THRESHOLD, 1 << 16);
  mallopt(M_TRIM_THRESHOLD, 1 << 16);
}

std::string process_name() { return std::to_string(::getpid()); }

bool standard_error_is_terminal() { return ::isatty(STDERR_FILENO) == 1; }

Result<std::filesystem::path> make_temporary_folder(const std::string& prefix) {
  std::error_code failure;
  const std::filesystem::path parent = std::filesystem::temp_directory_path(failure);
  if (failure) return Error{ErrorCode::kIo, "no folder for temporary files: " + failure.message()};
  std::string pattern = (parent / (prefix + "-XXXXXX")).string();
  if (::mkdtemp(pattern.data()) == nullptr)
    return Error{ErrorCode::kIo, std::string("cannot make a temporary folder: ") + std::strerror(errno), pattern};
  return std::filesystem::path(pattern);
}

}  // namespace zc
