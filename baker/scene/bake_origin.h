// SPDX-License-Identifier: GPL-3.0-or-later
// Where a scene came from and what the import was asked for, as bake.json keeps it: what another bake needs to give the
// same world. Paths as the caller gave them. Plain values.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace zc {

struct InputIdentity {
  std::string path;
  std::optional<std::uint64_t> bytes;  // none of a stream or a web address
  std::string xxh3;                    // of the content, 16 hexadecimal digits; empty without bytes
};

struct BakeOrigin {
  std::string version;  // of the program; empty: not known
  std::vector<InputIdentity> inputs;
  std::optional<InputIdentity> materials;  // the file of --materials
  std::string ground_plane;                // as given; empty: none
  bool wet = false;
  bool skip_missing = false;
  bool strict = false;
  // As given, once for all inputs or once for each.
  std::vector<std::string> scale = {}, up = {}, offset = {}, crs = {};
};

}  // namespace zc
