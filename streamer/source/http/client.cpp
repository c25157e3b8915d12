// SPDX-License-Identifier: Apache-2.0
// The thread that drives all transfers: begins what waits, lets libcurl work, ends what is over.
#include "streamer/source/http/client.h"

#include <curl/curl.h>
#include <signal.h>

#include <algorithm>
#include <chrono>
#include <deque>
#include <mutex>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

#include "base/check.h"
#include "streamer/source/http/transfer.h"

namespace zc {
namespace {

constexpr std::size_t kMostAtOnce = 8;  // requests, and so connections

}  // namespace

class HttpClient::Impl {
 public:
  Impl(CURLM* multi, double timeout_s) : multi_(multi), timeout_s_(timeout_s) {
    thread_ = std::thread([this] { run(); });
  }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  ~Impl() {
    {
      const std::lock_guard lock(mutex_);
      stop_ = true;
    }
    wake();
    thread_.join();
    ZC_CHECK(queue_.empty() && active_.empty());
    curl_multi_cleanup(multi_);
  }

  void submit(std::shared_ptr<Transfer> transfer) {
    {
      const std::lock_guard lock(mutex_);
      queue_.push_back(std::move(transfer));
    }
    wake();
  }

  void wake() { curl_multi_wakeup(multi_); }

  [[nodiscard]] HttpCounts counts() const {
    const std::lock_guard lock(mutex_);
    return counts_;
  }

 private:
  void run() {
    // OpenSSL writes to sockets without saying that a closed one must not raise the signal.
    sigset_t pipe;
    sigemptyset(&pipe);
    sigaddset(&pipe, SIGPIPE);
    pthread_sigmask(SIG_BLOCK, &pipe, nullptr);
    while (start_queued()) {
      int running = 0;
      curl_multi_perform(multi_, &running);
      int left = 0;
      while (const CURLMsg* message = curl_multi_info_read(multi_, &left)) {
        if (message->msg != CURLMSG_DONE) continue;
        Transfer* transfer = nullptr;
        curl_easy_getinfo(message->easy_handle, CURLINFO_PRIVATE, &transfer);
        finish(*transfer, transfer->conclude(message->data.result));
      }
      reap();
      if (!may_begin()) curl_multi_poll(multi_, nullptr, 0, poll_ms(), nullptr);
    }
  }

  // Begins what waits; false when the thread is to end.
  bool start_queued() {
    std::vector<std::shared_ptr<Transfer>> fresh, dropped;
    {
      const std::lock_guard lock(mutex_);
      if (stop_ && queue_.empty() && active_.empty()) return false;
      for (auto next = queue_.begin(); next != queue_.end();) {  // whatever its place in the queue
        if (!(*next)->cancelled()) {
          ++next;
          continue;
        }
        dropped.push_back(std::move(*next));
        next = queue_.erase(next);
      }
      while (active_.size() + fresh.size() < kMostAtOnce && !queue_.empty()) {
        fresh.push_back(std::move(queue_.front()));
        queue_.pop_front();
      }
      counts_.requests += fresh.size();
    }
    for (const auto& transfer : dropped) transfer->publish(cancelled(*transfer));
    for (auto& transfer : fresh) {
      active_.push_back(transfer);
      if (!transfer->open(timeout_s_) || curl_multi_add_handle(multi_, transfer->handle()) != CURLM_OK)
        finish(*transfer, transfer->failure("out of memory"));
    }
    return true;
  }

  // Whether something waits that what has ended makes room for.
  [[nodiscard]] bool may_begin() const {
    const std::lock_guard lock(mutex_);
    return !queue_.empty() && active_.size() < kMostAtOnce;
  }

  // Ends what was cancelled or stalls.
  void reap() {
    const std::vector<std::shared_ptr<Transfer>> now = active_;
    for (const auto& transfer : now) {
      if (transfer->cancelled()) {
        finish(*transfer, cancelled(*transfer));
      } else if (transfer->stalled(timeout_s_)) {
        finish(*transfer, transfer->failure("the server stalls"));
      }
    }
  }

  static Error cancelled(const Transfer& transfer) { return transfer.failure("cancelled"); }

  void finish(Transfer& transfer, Result<HttpAnswer> outcome) {
    if (transfer.handle() != nullptr) curl_multi_remove_handle(multi_, transfer.handle());
    transfer.close();
    {
      const std::lock_guard lock(mutex_);
      counts_.bytes_received += transfer.body_bytes();
      if (!outcome.ok() && !transfer.cancelled()) ++counts_.failed;
      if (outcome.ok() && outcome->status == 304) ++counts_.not_modified;
    }
    const auto found = std::ranges::find_if(active_, [&](const auto& other) { return other.get() == &transfer; });
    ZC_CHECK(found != active_.end());
    const std::shared_ptr<Transfer> kept = std::move(*found);
    active_.erase(found);
    kept->publish(std::move(outcome));
  }

  [[nodiscard]] int poll_ms() const {
    if (active_.empty()) return 60'000;  // until it is woken
    using Clock = Transfer::Clock;
    const auto timeout = std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(timeout_s_));
    auto next = Clock::now() + std::chrono::seconds(1);
    for (const auto& transfer : active_) next = std::min(next, transfer->last_check() + timeout);
    const auto ms = std::chrono::duration_cast<std::chrono::milliseconds>(next - Clock::now()).count();
    return static_cast<int>(std::max<std::int64_t>(ms + 1, 0));
  }

  CURLM* const multi_;
  const double timeout_s_;
  mutable std::mutex mutex_;
  std::deque<std::shared_ptr<Transfer>> queue_;
  HttpCounts counts_;
  bool stop_ = false;
  std::vector<std::shared_ptr<Transfer>> active_;  // the thread's own
  std::thread thread_;
};

HttpClient::Download::~Download() {
  if (!transfer_) return;
  cancel();
  (void)wait();  // its memory is the network thread's until then
}

const Result<HttpAnswer>& HttpClient::Download::wait() { return transfer_->wait(); }

void HttpClient::Download::cancel() {
  transfer_->cancel();
  client_->wake();
}

Result<std::unique_ptr<HttpClient>> HttpClient::create(double timeout_s) {
  static const CURLcode kReady = curl_global_init(CURL_GLOBAL_DEFAULT);  // once, before any thread of ours
  CURLM* multi = kReady == CURLE_OK ? curl_multi_init() : nullptr;
  if (multi == nullptr) return Error{ErrorCode::kIo, "libcurl cannot be set up"};
  curl_multi_setopt(multi, CURLMOPT_PIPELINING, static_cast<long>(CURLPIPE_MULTIPLEX));
  curl_multi_setopt(multi, CURLMOPT_MAXCONNECTS, static_cast<long>(kMostAtOnce));
  try {
    return std::unique_ptr<HttpClient>(new HttpClient(std::make_unique<Impl>(multi, timeout_s)));
  } catch (const std::system_error& failure) {
    curl_multi_cleanup(multi);
    return Error{ErrorCode::kIo, std::string("no thread for the network: ") + failure.what()};
  }
}

HttpClient::HttpClient(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
HttpClient::~HttpClient() = default;

HttpClient::Download HttpClient::start(HttpRequest request) {
  auto transfer = std::make_shared<Transfer>(std::move(request));
  impl_->submit(transfer);
  return {*impl_, std::move(transfer)};
}

Result<HttpAnswer> HttpClient::fetch(HttpRequest request) {
  const Download download = start(std::move(request));
  return std::move(download.transfer_->wait());
}

HttpCounts HttpClient::counts() const { return impl_->counts(); }

}  // namespace zc
