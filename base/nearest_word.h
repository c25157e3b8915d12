// SPDX-License-Identifier: Apache-2.0
// The word that somebody who typed another one may have meant. Thread-safe: no state.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>

namespace zc {

// The number of letters to insert, leave out, replace, or swap with their neighbour (Damerau 1964, each letter once).
std::size_t edit_distance(std::string_view a, std::string_view b);

// "; did you mean 'virtual'?" where one of the names is near, else nothing.
std::string did_you_mean(std::string_view word, std::span<const std::string> names);

}  // namespace zc
