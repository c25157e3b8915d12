// SPDX-License-Identifier: Apache-2.0
// Memory for arrays that may be large: on cache lines, and in huge pages where the system lends them, so that filling
// one is not a page fault every 4 KiB. Thread-safe: no state.
#pragma once

#include <sys/mman.h>

#include <cstddef>
#include <new>

namespace zc {

template <class T>
class LargeAllocator {
 public:
  using value_type = T;

  LargeAllocator() = default;
  template <class U>
  LargeAllocator(const LargeAllocator<U>&) {}  // NOLINT(google-explicit-constructor)

  [[nodiscard]] T* allocate(std::size_t count) {
    const std::size_t bytes = count * sizeof(T);
    void* memory = ::operator new(bytes, alignment(bytes));
    if (bytes >= kHugePage) ::madvise(memory, bytes, MADV_HUGEPAGE);  // a wish: it may be refused
    return static_cast<T*>(memory);
  }
  void deallocate(T* memory, std::size_t count) { ::operator delete(memory, alignment(count * sizeof(T))); }
  bool operator==(const LargeAllocator&) const = default;

 private:
  static constexpr std::size_t kHugePage = 2 << 20U;
  static std::align_val_t alignment(std::size_t bytes) {
    return static_cast<std::align_val_t>(bytes >= kHugePage ? kHugePage : 64);
  }
};

}  // namespace zc
