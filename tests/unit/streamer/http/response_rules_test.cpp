// SPDX-License-Identifier: Apache-2.0
// What an HTTP source accepts of a server, and which of its failures may pass.
#include "streamer/source/http/response_rules.h"

#include <gtest/gtest.h>

#include <initializer_list>

#include "streamer/source/http/retry_policy.h"

namespace zc {
namespace {

HttpRequest whole(std::uint64_t limit_bytes) {
  return {.url = "http://host/a", .name = "a", .limit_bytes = limit_bytes};
}
HttpRequest ranged(std::uint64_t first, std::uint64_t bytes) {
  HttpRequest request = whole(bytes);
  request.range = HttpRange{first, bytes};
  return request;
}

// The answer, or the first error on the way to it.
Result<HttpAnswer> answer_to(const HttpRequest& request, long status, std::initializer_list<std::string> headers,
                             std::size_t body_bytes) {
  ResponseRules rules(request);
  if (auto error = rules.add_header("HTTP/1.1 " + std::to_string(status) + "\r\n", status)) return *error;
  for (const std::string& line : headers)
    if (auto error = rules.add_header(line + "\r\n", status)) return *error;
  if (auto error = rules.add_header("\r\n", status)) return *error;
  const std::vector<std::byte> part(7);
  for (std::size_t left = body_bytes; left > 0;) {
    const std::size_t some = std::min(left, part.size());
    if (auto error = rules.add_body(std::span(part).first(some))) return *error;
    left -= some;
  }
  return rules.finish(status);
}

ErrorCode code_of(const Result<HttpAnswer>& answer) {
  EXPECT_FALSE(answer.ok());
  return answer.ok() ? ErrorCode::kDevice : answer.error().code;
}

TEST(ResponseRules, a_whole_file_is_as_long_as_announced_and_as_allowed) {
  const auto answer = answer_to(whole(20), 200, {"ETag: \"x\"", "content-LENGTH:  20 ", "Last-Modified: then"}, 20);
  ASSERT_TRUE(answer.ok());
  EXPECT_EQ(answer->etag, "\"x\"");
  EXPECT_EQ(answer->last_modified, "then");
  EXPECT_EQ(answer->file_bytes, 20U);
  EXPECT_EQ(answer->body.size(), 20U);
  EXPECT_TRUE(answer_to(whole(20), 200, {}, 13).ok());  // nothing was announced
  EXPECT_EQ(code_of(answer_to(whole(20), 200, {"Content-Length: 20"}, 19)), ErrorCode::kTransient);
  EXPECT_EQ(code_of(answer_to(whole(20), 200, {"Content-Length: 21"}, 0)), ErrorCode::kFormat);
  EXPECT_EQ(code_of(answer_to(whole(20), 200, {}, 21)), ErrorCode::kFormat);
  EXPECT_TRUE(answer_to(whole(20), 200, {"Content-Length: 20x"}, 3).ok());  // no number
}

TEST(ResponseRules, a_range_is_the_one_that_was_asked_for_or_ends_with_the_file) {
  const HttpRequest request = ranged(100, 50);
  const auto answer = answer_to(request, 206, {"Content-Range: bytes 100-149/1000"}, 50);
  ASSERT_TRUE(answer.ok());
  EXPECT_EQ(answer->first_byte, 100U);
  EXPECT_EQ(answer->file_bytes, 1000U);
  EXPECT_TRUE(answer_to(request, 206, {"Content-Range: bytes 100-149/*"}, 50).ok());
  EXPECT_TRUE(answer_to(request, 206, {"Content-Range: bytes 100-119/120"}, 20).ok());
  for (const char* range : {"bytes 101-150/1000", "bytes 100-150/1000", "bytes 100-119/1000", "bytes 100-149/149",
                            "bytes 149-100/1000", "bytes 100-149", "items 100-149/1000", "bytes 100-149/1000x", ""})
    EXPECT_EQ(code_of(answer_to(request, 206, {std::string("Content-Range: ") + range}, 50)), ErrorCode::kTransient)
        << range;
  EXPECT_EQ(code_of(answer_to(request, 206, {"Content-Range: bytes 100-149/1000"}, 49)), ErrorCode::kTransient);
  EXPECT_EQ(code_of(answer_to(whole(50), 206, {"Content-Range: bytes 0-49/50"}, 50)), ErrorCode::kTransient);
  EXPECT_EQ(code_of(answer_to(request, 200, {}, 50)), ErrorCode::kIo);
}

TEST(ResponseRules, the_end_of_a_file_is_its_end) {
  HttpRequest request = whole(50);
  request.last_bytes = 50;
  EXPECT_TRUE(answer_to(request, 206, {"Content-Range: bytes 950-999/1000"}, 50).ok());
  EXPECT_TRUE(answer_to(request, 206, {"Content-Range: bytes 0-29/30"}, 30).ok());
  EXPECT_FALSE(answer_to(request, 206, {"Content-Range: bytes 949-998/1000"}, 50).ok());
  EXPECT_FALSE(answer_to(request, 206, {"Content-Range: bytes 949-999/1000"}, 51).ok());
}

TEST(ResponseRules, a_version_is_kept_or_reported_as_changed) {
  HttpRequest request = ranged(0, 5);
  request.if_range = "\"old\"";
  const auto changed = answer_to(request, 200, {"ETag: \"new\""}, 5);
  EXPECT_EQ(code_of(changed), ErrorCode::kIo);
  EXPECT_NE(changed.error().message.find("changed"), std::string::npos);
  const auto unranged = answer_to(request, 200, {"ETag: \"old\""}, 5);
  EXPECT_EQ(unranged.error().message.find("changed"), std::string::npos);
  EXPECT_EQ(code_of(answer_to(whole(5), 304, {}, 0)), ErrorCode::kTransient);
  HttpRequest known = whole(5);
  known.if_none_match = "\"old\"";
  EXPECT_EQ(answer_to(known, 304, {"Content-Length: 500"}, 0)->status, 304);
  EXPECT_TRUE(strong_etag("\"a\""));
  EXPECT_FALSE(strong_etag("W/\"a\""));
  EXPECT_FALSE(strong_etag(""));
}

TEST(ResponseRules, headers_are_bounded_and_those_of_another_answer_forgotten) {
  const HttpRequest five = whole(5);
  ResponseRules rules(five);
  EXPECT_FALSE(rules.add_header("HTTP/1.1 301 Moved\r\n", 301));
  EXPECT_FALSE(rules.add_header("Content-Length: 1000\r\n", 301));
  EXPECT_FALSE(rules.add_header("Content-Encoding: br\r\n", 301));
  EXPECT_FALSE(rules.add_header("\r\n", 301));
  EXPECT_FALSE(rules.add_header("HTTP/1.1 200 OK\r\n", 200));
  EXPECT_FALSE(rules.add_header("\r\n", 200));
  EXPECT_FALSE(rules.add_body(std::vector<std::byte>(5)));
  EXPECT_TRUE(rules.add_body(std::vector<std::byte>(1)));
  EXPECT_EQ(code_of(answer_to(whole(5), 200, {"Content-Encoding: GZIP"}, 5)), ErrorCode::kIo);
  EXPECT_TRUE(answer_to(whole(5), 200, {"Content-Encoding: Identity"}, 5).ok());
  EXPECT_EQ(answer_to(whole(5), 200, {"ETag: " + std::string(300, 'x')}, 5)->etag, "");
  ResponseRules endless(five);
  int lines = 0;
  while (lines < 2000 && !endless.add_header("X-Header: " + std::string(100, 'x'), 200)) ++lines;
  EXPECT_LT(lines, 700);
}

TEST(RetryPolicy, what_may_pass_is_tried_again_when_the_server_says) {
  const HttpRequest request = whole(5);
  for (const long status : {200L, 206L, 304L}) EXPECT_FALSE(status_failure(request, status, 5)) << status;
  for (const long status : {408L, 425L, 429L, 500L, 502L, 503L, 599L}) {
    const auto error = status_failure(request, status, 7.0);
    ASSERT_TRUE(error);
    EXPECT_EQ(error->code, ErrorCode::kTransient) << status;
    EXPECT_EQ(error->retry_after_s, 7.0);
  }
  for (const long status : {0L, 204L, 301L, 400L, 401L, 403L, 404L, 410L, 416L}) {
    const auto error = status_failure(request, status, 7.0);
    ASSERT_TRUE(error);
    EXPECT_EQ(error->code, status == 404 || status == 410 ? ErrorCode::kMissing : ErrorCode::kIo) << status;
    EXPECT_EQ(error->retry_after_s, 10.0);
  }
  EXPECT_EQ(status_failure(request, 503, 1e9)->retry_after_s, 3600);
  EXPECT_EQ(status_failure(request, 503, -5)->retry_after_s, 0);
  EXPECT_EQ(transfer_failure(request, CURLE_COULDNT_CONNECT, "").code, ErrorCode::kTransient);
  EXPECT_EQ(transfer_failure(request, CURLE_TOO_MANY_REDIRECTS, "").code, ErrorCode::kIo);
  EXPECT_EQ(transfer_failure(request, CURLE_PEER_FAILED_VERIFICATION, "its words").message, "its words");
}

}  // namespace
}  // namespace zc
