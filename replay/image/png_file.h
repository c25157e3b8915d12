// SPDX-License-Identifier: Apache-2.0
// Pictures as PNG files, through libspng. Thread-safe: no state.
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "base/result.h"

namespace zc {

struct Picture {
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  std::vector<std::uint8_t> rgba;  // sRGB, 4 bytes a pixel, top row first
};

// Says within the file that this program wrote it.
Status write_png(const std::filesystem::path& file, const Picture& picture);
// Removes the file, where write_png() wrote it.
Status remove_written_png(const std::filesystem::path& file);
// Removes the pictures in a folder that write_png() wrote, and the folder if nothing else is in it. One that is not
// there will do.
Status remove_written_pngs(const std::filesystem::path& folder);

// All pictures on one sheet, `columns` a row, each scaled down by a box filter to tile_width. All pictures have one
// size.
Picture make_contact_sheet(const std::vector<Picture>& pictures, std::uint32_t columns, std::uint32_t tile_width);
// The tile alone.
Picture scale_down(const Picture& picture, std::uint32_t width);

}  // namespace zc
