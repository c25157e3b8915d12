// SPDX-License-Identifier: GPL-3.0-or-later
// gzip: RFC 1952. deflate: RFC 1951.
#include "baker/import/shared/gunzip.h"

#include <zlib.h>

#include <algorithm>
#include <limits>
#include <string_view>

namespace zc {
namespace {

constexpr int kGzipWindow = 15 + 16;
constexpr int kRawWindow = -15;
constexpr std::size_t kStepBytes = std::size_t{1} << 20U;

class Inflater {
 public:
  explicit Inflater(int window) { ready_ = inflateInit2(&stream_, window) == Z_OK; }
  Inflater(const Inflater&) = delete;
  Inflater& operator=(const Inflater&) = delete;
  ~Inflater() {
    if (ready_) inflateEnd(&stream_);
  }

  // One stream from the front of `in`, which keeps what is behind it, onto the end of `out`. limit_of: how long that
  // may be once so many bytes of `in` are read.
  template <class LimitOf>
  Status run(std::span<const std::byte>& in, std::vector<std::byte>& out, const std::string& path,
             const LimitOf& limit_of) {
    if (!ready_ || inflateReset(&stream_) != Z_OK) return Error{ErrorCode::kBudget, "zlib has no memory", path};
    const std::size_t start = in.size();
    for (int state = Z_OK; state != Z_STREAM_END;) {
      const std::size_t had = out.size();
      // One byte more than allowed shows that there are more.
      const std::uint64_t allowed = limit_of(start - in.size());
      const std::uint64_t room = allowed - std::min<std::uint64_t>(had, allowed) + 1;
      const auto step = static_cast<uInt>(std::min<std::uint64_t>(room, std::max(kStepBytes, had / 2)));
      const auto feed = static_cast<uInt>(std::min<std::size_t>(in.size(), std::numeric_limits<uInt>::max() / 2));
      out.resize(had + step);
      stream_.next_in = const_cast<Bytef*>(reinterpret_cast<const Bytef*>(in.data()));  // zlib does not write there
      stream_.avail_in = feed;
      stream_.next_out = reinterpret_cast<Bytef*>(out.data() + had);
      stream_.avail_out = step;
      state = inflate(&stream_, Z_NO_FLUSH);
      in = in.subspan(feed - stream_.avail_in);
      out.resize(had + step - stream_.avail_out);
      const auto at = static_cast<std::int64_t>(start - in.size());
      if (const std::uint64_t limit = limit_of(start - in.size()); out.size() > limit)
        return Error{ErrorCode::kUnsupported, "unpacks to more than the " + std::to_string(limit) + " bytes allowed",
                     path};
      if (state != Z_OK && state != Z_STREAM_END && !(state == Z_BUF_ERROR && stream_.avail_out == 0))
        return Error{ErrorCode::kFormat,
                     in.empty() ? "compressed data ends early: get the file again"
                                : "compressed data is damaged: get the file again",
                     path, at};
    }
    return {};
  }

 private:
  z_stream stream_ = {};
  bool ready_ = false;
};

}  // namespace

bool is_gzip(std::span<const std::byte> bytes) {
  return bytes.size() >= 2 && bytes[0] == std::byte{0x1F} && bytes[1] == std::byte{0x8B};
}

bool is_zip(std::span<const std::byte> bytes) {
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  return text.starts_with("PK\x03\x04") || text.starts_with("PK\x05\x06");
}

Result<std::vector<std::byte>> gunzip(std::span<const std::byte> bytes, const std::string& path,
                                      std::uint64_t limit_bytes, std::uint64_t ratio) {
  std::vector<std::byte> out;
  Inflater inflater(kGzipWindow);
  std::uint64_t read = 0;  // of the members before
  while (is_gzip(bytes)) {
    const std::size_t before = bytes.size();
    ZC_TRY(inflater.run(bytes, out, path,
                        [&](std::uint64_t more) { return std::max(limit_bytes, ratio * (read + more)); }));
    read += before - bytes.size();
  }
  return out;
}

Result<std::vector<std::byte>> inflate_raw(std::span<const std::byte> bytes, const std::string& path,
                                           std::uint64_t out_bytes) {
  std::vector<std::byte> out;
  Inflater inflater(kRawWindow);
  ZC_TRY(inflater.run(bytes, out, path, [&](std::uint64_t) { return out_bytes; }));
  if (out.size() != out_bytes)
    return Error{ErrorCode::kFormat, "unpacks to another size than declared: get the file again", path};
  return out;
}

}  // namespace zc
