// SPDX-License-Identifier: Apache-2.0
// What folders and archives on a web server have in common: the client, the cache, async reads, and the watch over the
// version that was opened. Threads: as streamer/source.h says.
#pragma once

#include <atomic>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "streamer/source/http/client.h"
#include "streamer/source/http/disk_cache.h"
#include "streamer/source/source.h"

namespace zc {

class WebWorld : public Source {
 public:
  // `watched`: the address whose version stands for the world's. `cache` may be null.
  WebWorld(std::unique_ptr<HttpClient> client, std::unique_ptr<DiskCache> cache, std::string url, std::string watched);

  Result<std::vector<std::byte>> read(const std::string& name, std::uint64_t bytes) override;
  std::unique_ptr<AsyncRead> begin(std::vector<WantedFile> files) override;
  [[nodiscard]] SourceStatistics statistics() const override;

 protected:
  struct Plan {
    std::vector<HttpRequest> requests;
    std::vector<std::size_t> request_of;  // by file
  };
  // How to ask for these files. Asks for nothing.
  [[nodiscard]] virtual Result<Plan> plan(std::span<const WantedFile> files) const = 0;
  // A file's bytes in the answer to its request; their number and hash are checked by the caller.
  [[nodiscard]] virtual Result<std::span<const std::byte>> cut(const HttpAnswer& answer,
                                                               const WantedFile& file) const = 0;

  // The version that counts from now on. Fails when another was given before.
  Status watch(const HttpAnswer& answer);
  // A range of the file `url`, of this version (a strong ETag), kept in the cache. `name`: what errors call it.
  Result<std::vector<std::byte>> read_range_of(const std::string& url, const std::string& name, HttpRange range,
                                               const std::string& etag);

  [[nodiscard]] const std::string& url() const { return url_; }
  [[nodiscard]] const std::string& shown_url() const { return shown_url_; }
  [[nodiscard]] HttpClient& client() const { return *client_; }
  [[nodiscard]] DiskCache* cache() const { return cache_.get(); }

 private:
  class WebRead;
  struct Version {
    std::string etag, last_modified;
    std::uint64_t bytes = 0;
    bool operator==(const Version&) const = default;
  };
  static Version version_of(const HttpAnswer& answer) { return {answer.etag, answer.last_modified, answer.file_bytes}; }
  [[nodiscard]] Error changed() const;
  // What is behind a file that is missing or not as the index says.
  [[nodiscard]] Error explain(Error error) const;
  [[nodiscard]] std::string key_of(const WantedFile& file) const;

  const std::unique_ptr<HttpClient> client_;
  const std::unique_ptr<DiskCache> cache_;
  const std::string url_, shown_url_, watched_;
  std::atomic<std::uint64_t> cache_hits_ = 0;
  mutable std::mutex mutex_;
  std::optional<Version> version_;
};

}  // namespace zc
