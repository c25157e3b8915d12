// SPDX-License-Identifier: Apache-2.0
// What the stages that draw read: camera, zones, pages and materials. They may not declare buffers that can be written.
#extension GL_EXT_scalar_block_layout : disable

#include "shared/frame.h"
#include "shared/page.h"
#include "shared/scene.h"

// How pages are read; see kBindProxyTexels.
layout(constant_id = 3) const uint kPoolPath = kPoolTexels;

layout(set = 0, binding = kBindFrame, std140) uniform FrameBlock { FrameData frame; };
layout(set = 0, binding = kBindProxyPool, std430) readonly buffer ProxyPool { uint proxy_pool[]; };
layout(set = 0, binding = kBindProxyPool4, std430) readonly buffer ProxyPool4 { uvec4 proxy_pool4[]; };
layout(set = 0, binding = kBindProxyTexels) uniform usamplerBuffer proxy_texels;
layout(set = 0, binding = kBindProxyTexels4) uniform usamplerBuffer proxy_texels4;
layout(set = 0, binding = kBindProxyZones, std430) readonly buffer ProxyZones { ZoneEntry proxy_zones[]; };
layout(set = 0, binding = kBindHostPool, std430) readonly buffer HostPool { uint host_pool[]; };
layout(set = 0, binding = kBindHostPool4, std430) readonly buffer HostPool4 { uvec4 host_pool4[]; };
layout(set = 0, binding = kBindHostTexels) uniform usamplerBuffer host_texels;
layout(set = 0, binding = kBindHostTexels4) uniform usamplerBuffer host_texels4;
layout(set = 0, binding = kBindHostZones, std430) readonly buffer HostZones { ZoneEntry host_zones[]; };

layout(set = 0, binding = kBindMaterials, std430) readonly buffer Materials { MaterialEntry materials[]; };

layout(push_constant) uniform PassBlock { PassConstants pass_constants; };
