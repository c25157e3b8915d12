// SPDX-License-Identifier: Apache-2.0
// ZC_CHECK: an invariant of our own code that stays on in release builds. Never for input from outside: that gets an
// Error.
#pragma once

#include <cstdio>
#include <cstdlib>

#define ZC_CHECK(condition)                                                                  \
  do {                                                                                       \
    if (!(condition)) {                                                                      \
      std::fprintf(stderr, "%s:%d: broken invariant: %s\n", __FILE__, __LINE__, #condition); \
      std::abort();                                                                          \
    }                                                                                        \
  } while (false)
