// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/import/tiles/web_files.h"

#include <utility>

#include "streamer/source/http/client.h"
#include "streamer/source/http/web_address.h"
#include "streamer/source/retry.h"

namespace zc {
namespace {

constexpr double kTimeout_s = 10;

class WebFiles final : public InputFiles {
 public:
  WebFiles(std::unique_ptr<HttpClient> client, std::string url, std::filesystem::path root, std::string root_url)
      : client_(std::move(client)), url_(std::move(url)), root_(std::move(root)), root_url_(std::move(root_url)) {}

  [[nodiscard]] Result<std::vector<std::byte>> read(const std::filesystem::path& file,
                                                    std::uint64_t limit_bytes) const override {
    HttpRequest request{.url = url_, .name = file.string(), .limit_bytes = limit_bytes};
    if (file != public_url(url_)) {
      ZC_ASSIGN(request.url, url_below(root_url_, file.lexically_relative(root_).generic_string()));
    }
    ZC_ASSIGN(HttpAnswer answer, with_retries([&] { return client_->fetch(request); }));
    return std::move(answer.body);
  }

 private:
  std::unique_ptr<HttpClient> client_;
  const std::string url_;
  const std::filesystem::path root_;
  const std::string root_url_;  // its query is the tileset's
};

// Without what stands behind the last slash of the path; the query stays.
std::string folder_url(const std::string& url) {
  const std::size_t end = std::min(url.find_first_of("?#"), url.size());
  const std::size_t host = url.find("://") + 3;
  const std::size_t slash = url.rfind('/', end == 0 ? 0 : end - 1);
  return slash == std::string::npos || slash < host ? url : url.substr(0, slash + 1) + url.substr(end);
}

}  // namespace

Result<WebTileset> open_web_files(const std::string& url) {
  ZC_ASSIGN(std::unique_ptr<HttpClient> client, HttpClient::create(kTimeout_s));
  ZC_TRY(url_below(url, "tileset.json"));  // fails when it is no address
  const std::filesystem::path path = public_url(url);
  return WebTileset{std::make_unique<WebFiles>(std::move(client), url, path.parent_path(), folder_url(url)), path};
}

}  // namespace zc
