// SPDX-License-Identifier: Apache-2.0
#include "streamer/source/http/web_world.h"

#include <deque>
#include <utility>

#include "streamer/source/http/response_rules.h"
#include "streamer/source/http/web_address.h"
#include "streamer/source/retry.h"

namespace zc {

class WebWorld::WebRead final : public AsyncRead {
 public:
  WebRead(WebWorld& world, std::vector<WantedFile> files) : world_(world), files_(std::move(files)) {
    parts_.resize(files_.size());
    std::vector<std::size_t> absent;
    for (std::size_t i = 0; i < files_.size(); ++i) {
      parts_[i].cached = world_.cache_ != nullptr && world_.cache_->has(world_.key_of(files_[i]));
      if (!parts_[i].cached) absent.push_back(i);
    }
    start(absent);
  }

  Result<std::span<const std::byte>> wait(std::size_t i) override {
    const WantedFile& file = files_[i];
    Part& part = parts_[i];
    if (part.cached) {
      if (auto bytes = world_.cache_->get(world_.key_of(file), file.bytes); bytes && check_wanted(*bytes, file).ok()) {
        ++world_.cache_hits_;
        part.bytes = *std::move(bytes);
        return std::span<const std::byte>(part.bytes);
      }
      part.cached = false;  // gone or damaged meanwhile
      world_.cache_->remove(world_.key_of(file));
      start({i});
    }
    if (part.failure) return *part.failure;
    const Result<HttpAnswer>& answer = part.download->wait();
    if (!answer) return answer.error().code == ErrorCode::kTransient ? answer.error() : world_.explain(answer.error());
    const Result<std::span<const std::byte>> bytes = world_.cut(*answer, file);
    if (!bytes) return world_.explain(bytes.error());
    if (Status sound = check_wanted(*bytes, file); !sound.ok()) {
      Error error = std::move(sound).error();
      error.code = ErrorCode::kTransient;  // it may have been damaged on the way
      return world_.explain(std::move(error));
    }
    if (world_.cache_ != nullptr) world_.cache_->put(world_.key_of(file), *bytes);
    return *bytes;
  }

  void cancel() override {
    const std::lock_guard lock(mutex_);
    cancelled_ = true;
    for (HttpClient::Download& download : downloads_) download.cancel();
  }

 private:
  struct Part {
    bool cached = false;
    HttpClient::Download* download = nullptr;
    std::optional<Error> failure;
    std::vector<std::byte> bytes;  // from the cache
  };

  void start(const std::vector<std::size_t>& which) {
    if (which.empty()) return;
    std::vector<WantedFile> files;
    for (const std::size_t i : which) files.push_back(files_[i]);
    Result<Plan> plan = world_.plan(files);
    if (!plan) {
      for (const std::size_t i : which) parts_[i].failure = plan.error();
      return;
    }
    const std::lock_guard lock(mutex_);
    const std::size_t first = downloads_.size();
    for (HttpRequest& request : plan->requests) {
      downloads_.push_back(world_.client_->start(std::move(request)));
      if (cancelled_) downloads_.back().cancel();
    }
    for (std::size_t k = 0; k < which.size(); ++k) parts_[which[k]].download = &downloads_[first + plan->request_of[k]];
  }

  WebWorld& world_;
  const std::vector<WantedFile> files_;
  std::vector<Part> parts_;
  std::mutex mutex_;
  std::deque<HttpClient::Download> downloads_;  // they stay where they are
  bool cancelled_ = false;
};

WebWorld::WebWorld(std::unique_ptr<HttpClient> client, std::unique_ptr<DiskCache> cache, std::string url,
                   std::string watched)
    : client_(std::move(client)),
      cache_(std::move(cache)),
      url_(std::move(url)),
      shown_url_(public_url(url_)),
      watched_(std::move(watched)) {}

Result<std::vector<std::byte>> WebWorld::read(const std::string& name, std::uint64_t bytes) {
  const WantedFile file{name, bytes, 0};
  return with_retries([&]() -> Result<std::vector<std::byte>> {
    ZC_ASSIGN(Plan plan, this->plan(std::span(&file, 1)));
    ZC_ASSIGN(HttpAnswer answer, client_->fetch(std::move(plan.requests.front())));
    ZC_ASSIGN(const std::span<const std::byte> found, cut(answer, file));
    if (found.size() != bytes)
      return Error{ErrorCode::kFormat,
                   "is " + std::to_string(found.size()) + " bytes, the index says " + std::to_string(bytes),
                   shown_url_ + ": " + name};
    if (found.size() == answer.body.size()) return std::move(answer.body);
    return std::vector<std::byte>(found.begin(), found.end());
  });
}

std::unique_ptr<AsyncRead> WebWorld::begin(std::vector<WantedFile> files) {
  return std::make_unique<WebRead>(*this, std::move(files));
}

SourceStatistics WebWorld::statistics() const {
  const HttpCounts counts = client_->counts();
  return {.requests = counts.requests,
          .failed = counts.failed,
          .bytes_received = counts.bytes_received,
          .not_modified = counts.not_modified,
          .cache_hits = cache_hits_,
          .cache_damaged = cache_ != nullptr ? cache_->damaged() : 0};
}

Status WebWorld::watch(const HttpAnswer& answer) {
  const std::lock_guard lock(mutex_);
  if (version_ && *version_ != version_of(answer)) return changed();
  version_ = version_of(answer);
  return {};
}

Result<std::vector<std::byte>> WebWorld::read_range_of(const std::string& url, const std::string& name, HttpRange range,
                                                       const std::string& etag) {
  const bool keep = cache_ != nullptr && strong_etag(etag);
  const std::string key =
      shown_url_ + '\n' + etag + '\n' + std::to_string(range.first) + '+' + std::to_string(range.bytes);
  if (keep)
    if (auto kept = cache_->get(key, range.bytes); kept && kept->size() == range.bytes) {
      ++cache_hits_;
      return *std::move(kept);
    }
  HttpRequest request{.url = url, .name = name, .range = range, .limit_bytes = range.bytes};
  if (strong_etag(etag)) request.if_range = etag;
  ZC_ASSIGN(HttpAnswer answer, with_retries([&] { return client_->fetch(request); }));
  ZC_TRY(watch(answer));
  if (answer.body.size() != range.bytes) return Error{ErrorCode::kFormat, "lies outside the archive", name};
  if (keep) cache_->put(key, answer.body);
  return std::move(answer.body);
}

Error WebWorld::changed() const {
  Error error{ErrorCode::kIo, "the world changed on the server since it was opened", shown_url_};
  error.retry_after_s = kLongestRetryDelay_s;
  return error;
}

Error WebWorld::explain(Error error) const {
  {
    const std::lock_guard lock(mutex_);
    if (!version_ || (version_->etag.empty() && version_->last_modified.empty())) return error;
  }
  const auto now = client_->fetch({.url = watched_, .name = shown_url_, .head = true});
  if (!now) return error;
  const std::lock_guard lock(mutex_);
  return version_of(*now) == *version_ ? std::move(error) : changed();
}

std::string WebWorld::key_of(const WantedFile& file) const {
  return shown_url_ + '\n' + file.name + '\n' + std::to_string(file.bytes) + '+' + std::to_string(file.xxh3);
}

}  // namespace zc
