// SPDX-License-Identifier: Apache-2.0
#include "streamer/source/http/response_rules.h"

#include <algorithm>
#include <charconv>
#include <system_error>
#include <utility>

#include "base/text.h"
#include "streamer/source/http/retry_policy.h"

namespace zc {
namespace {

constexpr std::size_t kHeaderLimitBytes = 64 << 10U;
constexpr std::size_t kValueLimitBytes = 256;          // of an ETag or a date
constexpr std::size_t kReserveLimitBytes = 64 << 20U;  // taken because a server announces it

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && static_cast<unsigned char>(text.back()) <= ' ') text.remove_suffix(1);
  while (!text.empty() && static_cast<unsigned char>(text.front()) <= ' ') text.remove_prefix(1);
  return text;
}

// Takes a number off the front.
std::optional<std::uint64_t> take_number(std::string_view& text) {
  std::uint64_t value = 0;
  const auto [end, failure] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (failure != std::errc()) return std::nullopt;
  text.remove_prefix(static_cast<std::size_t>(end - text.data()));
  return value;
}

}  // namespace

bool strong_etag(std::string_view etag) { return etag.size() >= 2 && etag.front() == '"'; }

// "bytes 0-99/1234", "bytes 0-99/*".
std::optional<ResponseRules::ContentRange> ResponseRules::parse_content_range(std::string_view text) {
  ContentRange range;
  if (!take(text, "bytes ")) return std::nullopt;
  const auto first = take_number(text);
  if (!first || !take(text, "-")) return std::nullopt;
  const auto last = take_number(text);
  if (!last || !take(text, "/") || *last < *first) return std::nullopt;
  range.first = *first;
  range.last = *last;
  if (text == "*") return range;
  const auto all = take_number(text);
  if (!all || !text.empty() || *last >= *all) return std::nullopt;
  range.file_bytes = *all;
  return range;
}

std::optional<Error> ResponseRules::add_header(std::string_view line, long status) {
  header_bytes_ += line.size();
  if (header_bytes_ > kHeaderLimitBytes) return transient_failure(request_, "the server sends headers without end");
  if (!trimmed(line).empty())
    take_header(line);
  else if (!status_failure(request_, status, std::nullopt))
    return check_headers(status);
  return std::nullopt;
}

void ResponseRules::take_header(std::string_view line) {
  if (line.starts_with("HTTP/")) {
    answer_ = {};
    content_range_.clear();
    encoding_.clear();
    announced_.reset();
    return;
  }
  const std::size_t colon = line.find(':');
  if (colon == std::string_view::npos) return;
  const std::string key = lower(line.substr(0, colon));
  const std::string_view value = trimmed(line.substr(colon + 1));
  if (value.size() > kValueLimitBytes) return;
  if (key == "etag") answer_.etag = value;
  if (key == "last-modified") answer_.last_modified = value;
  if (key == "content-range") content_range_ = value;
  if (key == "content-encoding") encoding_ = lower(value);
  if (key == "content-length") {
    std::string_view digits = value;
    announced_ = take_number(digits);
    if (!digits.empty()) announced_.reset();
  }
}

std::optional<Error> ResponseRules::check_headers(long status) {
  if (!encoding_.empty() && encoding_ != "identity")
    return lasting_failure(request_, "the server sends it encoded as " + encoding_);
  if (status == 304 && request_.if_none_match.empty())
    return transient_failure(request_, "the server answers with status 304 unasked");
  if (status == 200 && request_.ranged() && !request_.head) {
    if (!request_.if_range.empty() && answer_.etag != request_.if_range)
      return lasting_failure(request_, "changed on the server since it was opened");
    return lasting_failure(request_, "the server does not answer requests for a range");
  }
  if (status == 206) {
    const std::optional<ContentRange> got = parse_content_range(content_range_);
    if (!request_.ranged() || !got || !fits(*got))
      return transient_failure(request_, "the server sends another range than asked for: '" + content_range_ + "'");
    answer_.first_byte = got->first;
    answer_.file_bytes = got->file_bytes;
    expected_ = got->last - got->first + 1;
  } else if (status == 200) {
    expected_ = announced_;
    answer_.file_bytes = announced_.value_or(0);
  }
  if (request_.head || status == 304) return std::nullopt;
  const std::uint64_t coming = std::max(expected_.value_or(0), announced_.value_or(0));
  if (coming > request_.limit_bytes) return too_long();
  answer_.body.reserve(std::min<std::uint64_t>(coming, kReserveLimitBytes));
  return std::nullopt;
}

// A range may end early only where the file does.
bool ResponseRules::fits(const ContentRange& got) const {
  if (request_.last_bytes > 0) return got.last - got.first < request_.last_bytes && got.last + 1 == got.file_bytes;
  const std::uint64_t last = request_.range->first + request_.range->bytes - 1;
  return got.first == request_.range->first &&
         (got.last == last || (got.last < last && got.last + 1 == got.file_bytes));
}

Error ResponseRules::too_long() const {
  return {ErrorCode::kFormat, "the server sends more than " + std::to_string(request_.limit_bytes) + " bytes",
          request_.name};
}

std::optional<Error> ResponseRules::add_body(std::span<const std::byte> part) {
  if (part.size() > request_.limit_bytes - answer_.body.size()) return too_long();
  answer_.body.insert(answer_.body.end(), part.begin(), part.end());
  return std::nullopt;
}

Result<HttpAnswer> ResponseRules::finish(long status) {
  answer_.status = static_cast<int>(status);
  if (status != 304 && !request_.head && expected_ && answer_.body.size() != *expected_)
    return transient_failure(request_, "the server sends " + std::to_string(answer_.body.size()) + " bytes of " +
                                           std::to_string(*expected_));
  return std::move(answer_);
}

}  // namespace zc
