// SPDX-License-Identifier: Apache-2.0
#include "streamer/source/http/web_address.h"

#include <curl/curl.h>

#include <memory>
#include <string_view>

namespace zc {
namespace {

struct UrlDeleter {
  void operator()(CURLU* url) const { curl_url_cleanup(url); }
};
using Url = std::unique_ptr<CURLU, UrlDeleter>;

Url parse_url(const std::string& text) {
  Url url(curl_url());
  if (url && curl_url_set(url.get(), CURLUPART_URL, text.c_str(), 0) != CURLUE_OK) url.reset();
  return url;
}

std::string part_of(CURLU* url, CURLUPart part) {
  char* text = nullptr;
  if (curl_url_get(url, part, &text, 0) != CURLUE_OK) return {};
  std::string out = text;
  curl_free(text);
  return out;
}

}  // namespace

std::string public_url(const std::string& url) {
  const Url parsed = parse_url(url);
  if (!parsed) return "an address that is none";
  for (const CURLUPart part :
       {CURLUPART_USER, CURLUPART_PASSWORD, CURLUPART_OPTIONS, CURLUPART_QUERY, CURLUPART_FRAGMENT})
    curl_url_set(parsed.get(), part, nullptr, 0);
  return part_of(parsed.get(), CURLUPART_URL);
}

Result<std::string> url_below(const std::string& url, const std::string& name) {
  const Url parsed = parse_url(url);
  if (!parsed) return Error{ErrorCode::kArgument, "not a web address", public_url(url)};
  std::string path = part_of(parsed.get(), CURLUPART_PATH);
  if (path.empty() || path.back() != '/') path += '/';
  constexpr std::string_view kPlain = "-._~/";
  for (const char c : name) {
    if ((c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
        kPlain.find(c) != std::string_view::npos) {
      path += c;
    } else {
      constexpr std::string_view kDigits = "0123456789ABCDEF";
      path += '%';
      path += kDigits[static_cast<unsigned char>(c) >> 4U];
      path += kDigits[static_cast<unsigned char>(c) & 15U];
    }
  }
  if (curl_url_set(parsed.get(), CURLUPART_PATH, path.c_str(), 0) != CURLUE_OK)
    return Error{ErrorCode::kArgument, "not a web address", public_url(url)};
  curl_url_set(parsed.get(), CURLUPART_FRAGMENT, nullptr, 0);
  return part_of(parsed.get(), CURLUPART_URL);
}

}  // namespace zc
