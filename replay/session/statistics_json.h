// SPDX-License-Identifier: Apache-2.0
// stats.json: the key names that scripts rely on (DESIGN, "Command line"). Thread-safe: no state.
#pragma once

#include <nlohmann/json.hpp>

#include "replay/session/replay_report.h"

namespace zc {

nlohmann::ordered_json statistics_json(const ReplayReport& report);

}  // namespace zc
