// SPDX-License-Identifier: Apache-2.0
// Quantities as people write them on the command line. Fails with kArgument, naming the text.
// Thread-safe: no state.
#pragma once

#include <cstdint>
#include <string>

#include "base/result.h"
#include "replay/paths/camera_path.h"
#include "streamer/world_format/sun_angles.h"

namespace zc {

Result<std::uint64_t> parse_bytes(const std::string& text);      // "64MiB", "2 GB", "4096"
Result<double> parse_seconds(const std::string& text);           // "50ms", "1.5s"
Result<double> parse_bytes_per_second(const std::string& text);  // "20MB/s"
std::string format_bytes(std::uint64_t bytes);                   // "12.3 MiB"

Result<FrameRange> parse_frames(const std::string& text);  // "A:B", "A:B:STEP", "all"

struct PictureSize {
  std::uint32_t width = 1280;
  std::uint32_t height = 720;
};
Result<PictureSize> parse_size(const std::string& text);  // "1280x720"

Result<SunAngles> parse_sun(const std::string& text);  // "145,38": azimuth, elevation (-90 to 90)

}  // namespace zc
