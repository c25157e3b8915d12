// SPDX-License-Identifier: Apache-2.0
// A pass of a reflected frame: one file here, one shader of the same name in shaders/passes/, and its name in the list
// PASSES of CMakeLists.txt, in the order of the frame. Layouts, push constants and workgroup sizes come from the
// shader; compiling, scheduling, timing and statistics follow from what a pass says of itself. Thread-safe: no state.
#pragma once

#include <cstdint>

#include "runtime/device/program.h"
#include "runtime/tracing/trace_queue.h"
#include "shaders/shared/frame.h"

namespace zc {

// What a scene and its settings ask of a frame.
struct Features {
  bool mirrors = true;           // some material mirrors
  bool screen = true;            // rays try the screen first
  bool thread_per_pixel = true;  // of work on pixels; a CPU prefers fewer and larger invocations
};

// Records a pass's commands, with its descriptors bound; a barrier follows each of them.
class PassRecorder {
 public:
  PassRecorder(VkCommandBuffer commands, Program& program, const BindingTable& table, std::uint32_t slot,
               const TraceQueue& queue, const gpu::FrameData& frame_data, const Features& frame_features)
      : frame(frame_data),
        features(frame_features),
        commands_(commands),
        program_(program),
        table_(table),
        slot_(slot),
        queue_(queue) {}

  // At least so many invocations, in workgroups of the size that the shader declares.
  void dispatch(std::uint32_t width, std::uint32_t height, const gpu::PassConstants* constants = nullptr);
  // As many workgroups as the counters say from there on: offsetof(gpu::Counters, …_groups_x).
  void dispatch_indirect(std::size_t counters_offset_bytes);
  // After passes that append to the lists of pixels or rays, before those that go over them.
  void size_lists();
  void trace_queue();

  const gpu::FrameData& frame;
  const Features& features;

 private:
  VkCommandBuffer commands_;
  Program& program_;
  const BindingTable& table_;
  std::uint32_t slot_;
  const TraceQueue& queue_;
};

struct Pass {
  const char* key;  // in statistics and left_out
  // Why a scene does not need it, or null where it does.
  const char* (*left_out)(const Features&);
  void (*record)(PassRecorder&);
};

// Reasons that several passes give.
inline const char* unless_mirrors(const Features& features) {
  return features.mirrors ? nullptr : "no material of this world mirrors";
}

}  // namespace zc
