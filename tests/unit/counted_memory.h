// SPDX-License-Identifier: Apache-2.0
// The memory that an executable holds, by its own operator new: included by one of its sources. AddressSanitizer has an
// operator new of its own; with it nothing is counted.
#pragma once

#include <malloc.h>

#include <atomic>
#include <cstddef>
#include <cstdlib>
#include <new>

#ifdef __SANITIZE_ADDRESS__

namespace zc::test {
inline constexpr bool kCountsMemory = false;
template <class Work>
long long most_memory_of(Work work) {
  work();
  return 0;
}
}  // namespace zc::test

#else

namespace zc::test {

inline constexpr bool kCountsMemory = true;
inline std::atomic<long long> held_bytes{0};
inline std::atomic<long long> most_bytes{0};

inline void* take(std::size_t bytes) {
  void* memory = std::malloc(bytes == 0 ? 1 : bytes);
  if (memory == nullptr) throw std::bad_alloc();
  const long long now = held_bytes += static_cast<long long>(malloc_usable_size(memory));
  long long most = most_bytes;
  while (now > most && !most_bytes.compare_exchange_weak(most, now)) {
  }
  return memory;
}

inline void drop(void* memory) {
  if (memory == nullptr) return;
  held_bytes -= static_cast<long long>(malloc_usable_size(memory));
  std::free(memory);
}

// Bytes that were held at a time during `work` beyond those before it.
template <class Work>
long long most_memory_of(Work work) {
  const long long before = held_bytes;
  most_bytes = before;
  work();
  return most_bytes - before;
}

}  // namespace zc::test

void* operator new(std::size_t bytes) { return zc::test::take(bytes); }
void* operator new[](std::size_t bytes) { return zc::test::take(bytes); }
void operator delete(void* memory) noexcept { zc::test::drop(memory); }
void operator delete[](void* memory) noexcept { zc::test::drop(memory); }
void operator delete(void* memory, std::size_t) noexcept { zc::test::drop(memory); }
void operator delete[](void* memory, std::size_t) noexcept { zc::test::drop(memory); }

#endif
