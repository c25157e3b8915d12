// SPDX-License-Identifier: GPL-3.0-or-later
// What one glTF file may grow to, in relation to its bytes: accessors without a bufferView are zeros, and any number of
// primitives, nodes and instances may name the same ones. Not thread-safe: one per file. Fails when a bound is passed.
#pragma once

#include <cstdint>
#include <string>
#include <utility>

#include "base/result.h"

namespace zc {

class GltfBudget {
 public:
  // bytes: of the file and the buffers that it names.
  GltfBudget(std::string path, std::uint64_t bytes) : path_(std::move(path)), bytes_(bytes) {}

  // Elements of an accessor that are about to be read. bare: no bytes stand behind them.
  Status read(std::uint64_t elements, bool bare, const std::string& where);
  // Vertices and triangles of a primitive, which stay in memory until the file is done.
  Status keep(std::uint64_t elements, const std::string& where);
  // Triangles that nodes show `times` times.
  Status draw(std::uint64_t triangles, std::uint64_t times, const std::string& where);

 private:
  struct Sum {
    std::uint64_t most = 0;
    std::uint64_t done = 0;

    [[nodiscard]] bool add(std::uint64_t count) {
      if (count > most - done) return false;
      done += count;
      return true;
    }
  };
  [[nodiscard]] Error beyond(const std::string& what, const Sum& sum, const std::string& next_step) const;

  std::string path_;
  std::uint64_t bytes_;
  Sum read_{(std::uint64_t{1} << 24U) + 64 * bytes_};
  Sum bare_{(std::uint64_t{1} << 20U) + bytes_};
  Sum kept_{(std::uint64_t{1} << 22U) + 4 * bytes_};
  Sum drawn_{(std::uint64_t{1} << 20U) + 4 * bytes_};
};

}  // namespace zc
