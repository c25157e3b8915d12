// SPDX-License-Identifier: Apache-2.0
#version 460

layout(location = 0) flat in uvec2 in_surface;
layout(location = 0) out uvec2 surface;

void main() {
  surface = in_surface;
}
