// SPDX-License-Identifier: Apache-2.0
// How much memory a Draco stream's rANS decoders will ask for, read from the stream before draco sees it: the streams
// name table sizes themselves, and the tables dominate the memory of decoding a small mesh.
// Source: draco 1.5.5 (mesh_edgebreaker_decoder_impl.cc, symbol_decoding.cc, rans_symbol_decoder.h), bitstream 2.2.
// Untrusted input. Thread-safe: pure.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

namespace zc {

// Bytes of the largest decoder's tables in a mesh stream with one or two attributes; nothing when the stream is damaged
// or of a kind that this does not follow. Only the last attribute's values may be tagged: those have no length.
std::optional<std::uint64_t> draco_table_bytes(std::span<const std::byte> stream);

// Tables for symbols of `bits` bits, `symbols` of them.
std::uint64_t rans_table_bytes(unsigned bits, std::uint64_t symbols);

}  // namespace zc
