// SPDX-License-Identifier: Apache-2.0
// For records without padding, that files and devices know by their bytes.
#pragma once

#include <algorithm>
#include <span>

namespace zc::test {

template <class T>
bool same_bytes(const T& a, const T& b) {
  return std::ranges::equal(std::as_bytes(std::span(&a, 1)), std::as_bytes(std::span(&b, 1)));
}

}  // namespace zc::test
