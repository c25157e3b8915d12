// SPDX-License-Identifier: Apache-2.0
// A replay: a world, a path or several, a cap, and what came of it.
// Threads: one caller. Fails on bad input, a cap that is too small, a device that refuses.
#pragma once

#include "base/result.h"
#include "replay/session/replay_options.h"
#include "replay/session/replay_report.h"

namespace zc {

Result<ReplayReport> run_replay(const ReplayOptions& options);

}  // namespace zc
