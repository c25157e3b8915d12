// SPDX-License-Identifier: Apache-2.0
#include "streamer/open_source.h"

#include <system_error>

#include "streamer/source/archive_source.h"
#include "streamer/source/http/http_source.h"

namespace zc {

Result<std::unique_ptr<Source>> open_source(const std::filesystem::path& place, const SourceOptions& options) {
  if (is_url(place.native())) return open_http_source(place.native(), options);
  std::error_code code;
  if (std::filesystem::is_directory(place, code)) return open_directory_source(place);
  if (!std::filesystem::exists(place, code)) return Error{ErrorCode::kIo, "no such world", place.string()};
  return open_archive_source(place);
}

}  // namespace zc
