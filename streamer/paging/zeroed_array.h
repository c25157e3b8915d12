// SPDX-License-Identifier: Apache-2.0
// An array of fixed size whose elements begin as zero bytes that the system hands out when they are first touched:
// state per node of a world of which little is ever looked at. Threads: as its elements.
#pragma once

#include <cstddef>
#include <cstdlib>
#include <memory>
#include <new>
#include <span>
#include <type_traits>

namespace zc {

template <class T>
class ZeroedArray {
  static_assert(std::is_trivially_copyable_v<T> && std::is_trivially_destructible_v<T>);

 public:
  explicit ZeroedArray(std::size_t size)
      : size_(size), elements_(static_cast<T*>(std::calloc(size == 0 ? 1 : size, sizeof(T)))) {
    if (!elements_) throw std::bad_alloc();
  }

  [[nodiscard]] std::size_t size() const { return size_; }
  T& operator[](std::size_t i) { return elements_.get()[i]; }
  const T& operator[](std::size_t i) const { return elements_.get()[i]; }
  [[nodiscard]] std::span<const T> view() const { return {elements_.get(), size_}; }
  [[nodiscard]] std::span<T> view() { return {elements_.get(), size_}; }

 private:
  struct Free {
    void operator()(T* elements) const { std::free(elements); }
  };
  std::size_t size_;
  std::unique_ptr<T, Free> elements_;
};

}  // namespace zc
