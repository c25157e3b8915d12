// SPDX-License-Identifier: Apache-2.0
// stats.json: the key names that scripts rely on (DESIGN, "Command line"). Thread-safe: no state.
#pragma once

#include <string>

#include "replay/session/replay_report.h"

namespace zc {

std::string statistics_text(const ReplayReport& report);

}  // namespace zc
