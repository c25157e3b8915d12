// SPDX-License-Identifier: Apache-2.0
// What the operating system is asked about this process and its allocator; a port to another system begins here. Linux
// with glibc. The other places that know the system: base/file.cpp (files), base/large_allocator.h (huge pages),
// base/folder_lock.cpp (locks), baker/write (renames that reach the disk), streamer/source/http/client.cpp (signals),
// replay/serve (sockets). Vector registers: base/simd.h. Thread-safe: no state, where a comment does not say otherwise.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "base/result.h"

namespace zc {

std::uint64_t resident_set_bytes();       // now
std::uint64_t peak_resident_set_bytes();  // since the start, or since the last reset
void reset_peak_resident_set();           // where the kernel allows it
// From now on freed blocks of 64 KiB go back to the system at once. Before threads start.
void return_freed_memory();

std::string process_name();  // unlike that of every other process that runs on this machine
bool standard_error_is_terminal();
Result<std::filesystem::path> make_temporary_folder(const std::string& prefix);  // empty, of this user alone

}  // namespace zc
