// SPDX-License-Identifier: Apache-2.0
#include "runtime/passes/pass.h"

#include "runtime/device/commands.h"

namespace zc {

void PassRecorder::dispatch(std::uint32_t width, std::uint32_t height, const gpu::PassConstants* constants) {
  program_.bind(commands_, table_, slot_);
  if (constants != nullptr) program_.push(commands_, std::as_bytes(std::span(constants, 1)));
  const std::array<std::uint32_t, 3>& group = program_.workgroup();
  vkCmdDispatch(commands_, (width + group[0] - 1) / group[0], (height + group[1] - 1) / group[1], 1);
  barrier_after_compute(commands_);
}

void PassRecorder::dispatch_indirect(std::size_t counters_offset_bytes) {
  program_.bind(commands_, table_, slot_);
  vkCmdDispatchIndirect(commands_, queue_.counters().handle(), counters_offset_bytes);
  barrier_after_compute(commands_);
}

void PassRecorder::size_lists() { queue_.record_sizes(commands_, table_, slot_); }

void PassRecorder::trace_queue() { queue_.record_trace(commands_, table_, slot_); }

}  // namespace zc
