// SPDX-License-Identifier: Apache-2.0
// What the vertex stages read: camera, zones and pages. They may not declare buffers that can be written.
#extension GL_EXT_scalar_block_layout : disable

#include "shared/frame.h"
#include "shared/page.h"
#include "shared/scene.h"

layout(set = 0, binding = kBindFrame, std140) uniform FrameBlock { FrameData frame; };
layout(set = 0, binding = kBindProxyPool, std430) readonly buffer ProxyPool { uint proxy_pool[]; };
layout(set = 0, binding = kBindProxyZones, std430) readonly buffer ProxyZones { ZoneEntry proxy_zones[]; };
layout(set = 0, binding = kBindProxyTop, std430) readonly buffer ProxyTop { TopNode proxy_top[]; };
layout(set = 0, binding = kBindHostPool, std430) readonly buffer HostPool { uint host_pool[]; };
layout(set = 0, binding = kBindHostZones, std430) readonly buffer HostZones { ZoneEntry host_zones[]; };
layout(set = 0, binding = kBindHostTop, std430) readonly buffer HostTop { TopNode host_top[]; };

layout(push_constant) uniform PassBlock { PassConstants pass_constants; };
