// SPDX-License-Identifier: Apache-2.0
// The stack of the one ray that an invocation traces: an array of its own, or with kStackShared the workgroup's shared
// memory, where entries of one height lie side by side, so that no two lanes read the same bank.
// Pages that nobody verified may be deeper than the stack: what does not fit goes to its last entry.
// Needs the workgroup's size declared before it.
#ifndef ZC_SHADERS_STACK
#define ZC_SHADERS_STACK

layout(constant_id = 6) const uint kStackShared = 0u;

const int kGroupSize = int(gl_WorkGroupSize.x * gl_WorkGroupSize.y);
uvec2 private_stack[kStackShared != 0u ? 1 : kStackSize];
shared uvec2 shared_stack[kStackShared != 0u ? kStackSize * kGroupSize : 1];

// Where the entry of a height lies.
int stack_place(int height) {
  const int row = min(height, kStackSize - 1);
  return kStackShared != 0u ? row * kGroupSize + int(gl_LocalInvocationIndex) : row;
}

uvec2 stack_entry(int height) {
  if (kStackShared != 0u) return shared_stack[stack_place(height)];
  return private_stack[stack_place(height)];
}

void set_stack_entry(int height, uvec2 entry) {
  if (kStackShared != 0u) {
    shared_stack[stack_place(height)] = entry;
  } else {
    private_stack[stack_place(height)] = entry;
  }
}

#endif
