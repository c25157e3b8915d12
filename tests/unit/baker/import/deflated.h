// SPDX-License-Identifier: GPL-3.0-or-later
// What the tests of packed inputs share: gzip and ZIP, written by hand.
#pragma once

#include <gtest/gtest.h>
#include <zlib.h>
#include <zstd.h>

#include <string>
#include <string_view>
#include <vector>

#include "tests/unit/baker/import/import_support.h"

namespace zc::test {

// window: 15 + 16 for gzip, -15 for bare deflate.
inline std::string deflated(std::string_view text, int window) {
  z_stream stream = {};
  EXPECT_EQ(deflateInit2(&stream, 9, Z_DEFLATED, window, 8, Z_DEFAULT_STRATEGY), Z_OK);
  std::string out(deflateBound(&stream, text.size()), '\0');
  stream.next_in = const_cast<Bytef*>(reinterpret_cast<const Bytef*>(text.data()));
  stream.avail_in = static_cast<uInt>(text.size());
  stream.next_out = reinterpret_cast<Bytef*>(out.data());
  stream.avail_out = static_cast<uInt>(out.size());
  EXPECT_EQ(deflate(&stream, Z_FINISH), Z_STREAM_END);
  out.resize(stream.total_out);
  deflateEnd(&stream);
  return out;
}

inline std::string gzipped(std::string_view text) { return deflated(text, 15 + 16); }

struct ZipEntry {
  std::string name;
  std::string text;
  std::uint16_t flags = 0;
  std::uint16_t method = 8;  // 0 stored, 93 Zstandard
};

// ZIP by the letter of APPNOTE 6.3.9: a local header before each file, then the directory, then its end.
inline std::string zipped(const std::vector<ZipEntry>& entries) {
  std::string file;
  std::string directory;
  for (const auto& [name, text, flags, method] : entries) {
    std::string packed = method == 8 ? deflated(text, -15) : text;
    if (method == 93) {
      packed.resize(ZSTD_compressBound(text.size()));
      packed.resize(ZSTD_compress(packed.data(), packed.size(), text.data(), text.size(), 3));
    }
    std::string common;  // of both headers
    append(common, std::uint16_t{20});
    append(common, flags);
    append(common, method);
    append(common, std::uint32_t{0x21});  // 1 January 1980
    append(common, static_cast<std::uint32_t>(
                       crc32(0, reinterpret_cast<const Bytef*>(text.data()), static_cast<uInt>(text.size()))));
    append(common, static_cast<std::uint32_t>(packed.size()));
    append(common, static_cast<std::uint32_t>(text.size()));
    append(common, static_cast<std::uint16_t>(name.size()));
    append(common, std::uint16_t{0});
    directory += std::string("PK\x01\x02") + std::string("\x14\0", 2) + common + std::string(10, '\0');
    append(directory, static_cast<std::uint32_t>(file.size()));
    directory += name;
    file += "PK\x03\x04" + common + name + packed;
  }
  std::string end = std::string("PK\x05\x06") + std::string(4, '\0');
  append(end, static_cast<std::uint16_t>(entries.size()));
  append(end, static_cast<std::uint16_t>(entries.size()));
  append(end, static_cast<std::uint32_t>(directory.size()));
  append(end, static_cast<std::uint32_t>(file.size()));
  append(end, std::uint16_t{0});
  return file + directory + end;
}

}  // namespace zc::test
