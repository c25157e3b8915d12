// SPDX-License-Identifier: Apache-2.0
// A world on a web server: a folder of files, each asked for whole, or, where the address ends in .3tz, an archive of
// which ranges are asked for; files of a page that lie side by side there come in one. Any server will do that serves
// static files, and ranges of an archive.
//
// A world that changes while it is open never gives mixed bytes: every page's file is compared with the index's hash;
// ranges of an archive are conditional on the ETag it was opened with; and after a file that is missing or not as the
// index says, the index (or the archive) is asked for again, so that the error says what happened. What may pass is
// kTransient (retry_policy.h).
//
// With a cache, a page's file that was read once, of whatever world version, is not asked for again while it lies
// there: its key contains the hash that the index asks for. What the index does not know goes by URL, ETag and range.
//
// Threads: as streamer/source.h says.
#pragma once

#include <memory>
#include <string>

#include "base/result.h"
#include "streamer/source/source.h"

namespace zc {

Result<std::unique_ptr<Source>> open_http_source(const std::string& url, const SourceOptions& options);

}  // namespace zc
