// SPDX-License-Identifier: Apache-2.0
#version 460

layout(location = 0) flat in uvec2 in_surface;
layout(location = 1) flat in uvec2 in_identity;
layout(location = 0) out uvec2 surface;
layout(location = 1) out uvec2 identity;

void main() {
  surface = in_surface;
  identity = in_identity;
}
