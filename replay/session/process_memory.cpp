// SPDX-License-Identifier: Apache-2.0
#include "replay/session/process_memory.h"

#include <fstream>
#include <string>

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

}  // namespace zc
