// SPDX-License-Identifier: Apache-2.0
// Lets one header compile as C++ and as GLSL: fixed-width scalar names only, so that std430 and C++ lay structs out
// alike (a test compares offsetof with the SPIR-V offsets).
#ifndef ZC_SHADERS_SHARED_SHARED_H
#define ZC_SHADERS_SHARED_SHARED_H

#ifdef __cplusplus
#include <cstddef>
#include <cstdint>
#define ZC_SHARED_BEGIN namespace zc::gpu {
#define ZC_SHARED_END }
#define ZC_CONST(type, name, value) inline constexpr type name = value
ZC_SHARED_BEGIN
using uint = std::uint32_t;
ZC_SHARED_END
#else
#define ZC_SHARED_BEGIN
#define ZC_SHARED_END
#define ZC_CONST(type, name, value) const type name = value
#endif

#endif
