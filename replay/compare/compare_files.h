// SPDX-License-Identifier: Apache-2.0
// What `compare` writes into its folder: a folder of pictures a level, one of maps of FLIP a level but the source, and
// compare.json. Threads: one. Fails when the disk does.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "replay/compare/compare.h"
#include "replay/image/png_file.h"

namespace zc {

class CompareFiles {
 public:
  // Pictures that an earlier run left there go; nothing else does.
  static Result<CompareFiles> create(const std::filesystem::path& out);

  // The folders of a level; once for each.
  Status add_level(const std::string& level, bool with_maps) const;
  Status write_picture(const std::string& level, const std::string& frame, const Picture& picture) const;
  Status write_map(const std::string& level, const std::string& frame, const Picture& map) const;
  Status write_sheet(const Picture& sheet) const;
  Status write_report(const CompareReport& report) const;

 private:
  explicit CompareFiles(std::filesystem::path out) : out_(std::move(out)) {}

  std::filesystem::path out_;
};

}  // namespace zc
