// SPDX-License-Identifier: Apache-2.0
// What the stand-in host's own passes bind beside passes/bindings.glsl.
#include "passes/bindings.glsl"

layout(set = 0, binding = kBindIrradianceOut, rgba16f) uniform writeonly image2D irradiance_out;
layout(set = 0, binding = kBindReflectionIn) uniform sampler2D reflection_in;
layout(set = 0, binding = kBindOutput, std430) buffer Output { uint output_rgba[]; };
