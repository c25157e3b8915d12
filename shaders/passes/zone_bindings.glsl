// SPDX-License-Identifier: Apache-2.0
// What stages that only read bind: camera, zones, pages and materials. Stages that draw may not declare buffers that
// can be written.
#include "shared/frame.h"
#include "shared/page.h"
#include "shared/scene.h"

// How pages are read; see kBindPoolTexels.
layout(constant_id = 3) const uint kPoolPath = kPoolTexels;

layout(set = 0, binding = kBindFrame, std140) uniform FrameBlock { FrameData frame; };
layout(set = 0, binding = kBindPool, std430) readonly buffer Pool { uint pool[]; };
layout(set = 0, binding = kBindPool4, std430) readonly buffer Pool4 { uvec4 pool4[]; };
layout(set = 0, binding = kBindPoolTexels) uniform usamplerBuffer pool_texels;
layout(set = 0, binding = kBindPoolTexels4) uniform usamplerBuffer pool_texels4;
layout(set = 0, binding = kBindZones, std430) readonly buffer Zones { ZoneEntry zones[]; };
layout(set = 0, binding = kBindMaterials, std430) readonly buffer Materials { MaterialEntry materials[]; };

layout(push_constant) uniform PassBlock { PassConstants pass_constants; };

uvec2 frame_size() { return uvec2(frame.width, frame.height); }
