// SPDX-License-Identifier: Apache-2.0
#include "streamer/source/http/client.h"

#include <curl/curl.h>
#include <signal.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <chrono>
#include <condition_variable>
#include <cstdlib>
#include <deque>
#include <exception>
#include <mutex>
#include <system_error>
#include <thread>

#include "base/check.h"
#include "base/text.h"
#include "streamer/source/retry.h"

namespace zc {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::size_t kMostAtOnce = 8;  // requests, and so connections
constexpr long kMostRedirects = 4;
constexpr std::size_t kHeaderLimitBytes = 64 << 10U;
constexpr std::size_t kValueLimitBytes = 256;            // of an ETag or a date
constexpr std::size_t kErrorBodyLimitBytes = 16 << 10U;  // read and dropped, so that the connection can be used again
constexpr std::size_t kReserveLimitBytes = 64 << 20U;    // taken because a server announces it
constexpr std::uint64_t kLeastBytes = 1024;              // in timeout_s; less is a stall
constexpr double kRetryAfterLimit_s = 3600;

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

struct ContentRange {
  std::uint64_t first = 0, last = 0, file_bytes = 0;  // 0: not told
};

// "bytes 0-99/1234", "bytes 0-99/*".
std::optional<ContentRange> parse_content_range(std::string_view text) {
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

bool passes(CURLcode code) {  // whether the same request may succeed later
  switch (code) {
    case CURLE_UNSUPPORTED_PROTOCOL:
    case CURLE_URL_MALFORMAT:
    case CURLE_TOO_MANY_REDIRECTS:
    case CURLE_PEER_FAILED_VERIFICATION:
    case CURLE_SSL_CACERT_BADFILE:
    case CURLE_SSL_CERTPROBLEM:
    case CURLE_WEIRD_SERVER_REPLY:
      return false;
    default:
      return true;
  }
}

}  // namespace

bool strong_etag(std::string_view etag) { return etag.size() >= 2 && etag.front() == '"'; }

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

struct HttpClient::Download::State {
  State(HttpClient::Impl& owner, HttpRequest what) : client(owner), request(std::move(what)) {}
  State(const State&) = delete;
  State& operator=(const State&) = delete;
  ~State() { drop_handles(); }

  // --- the client's thread, until `result` is there ---

  bool prepare(double timeout_s) {
    easy = curl_easy_init();
    if (easy == nullptr) return false;
    const auto set = [&](CURLoption option, auto value) { curl_easy_setopt(easy, option, value); };
    const bool secure = request.url.starts_with("https:");
    set(CURLOPT_URL, request.url.c_str());
    set(CURLOPT_PRIVATE, static_cast<void*>(this));
    set(CURLOPT_ERRORBUFFER, text.data());
    set(CURLOPT_NOSIGNAL, 1L);
    set(CURLOPT_USERAGENT, "zonecast");
    set(CURLOPT_PROTOCOLS_STR, "http,https");
    set(CURLOPT_REDIR_PROTOCOLS_STR, secure ? "https" : "http,https");
    set(CURLOPT_FOLLOWLOCATION, 1L);
    set(CURLOPT_MAXREDIRS, kMostRedirects);
    set(CURLOPT_HTTP_VERSION, static_cast<long>(CURL_HTTP_VERSION_2TLS));
    set(CURLOPT_PIPEWAIT, secure ? 1L : 0L);  // rather one connection of HTTP/2 than many
    set(CURLOPT_CONNECTTIMEOUT_MS, static_cast<long>(1e3 * timeout_s));
    set(CURLOPT_HEADERFUNCTION, &State::on_header);
    set(CURLOPT_HEADERDATA, static_cast<void*>(this));
    set(CURLOPT_WRITEFUNCTION, &State::on_body);
    set(CURLOPT_WRITEDATA, static_cast<void*>(this));
    // Where the curl command looks for the certificates of a house's own authority.
    if (const char* bundle = std::getenv("CURL_CA_BUNDLE"); bundle != nullptr && *bundle != '\0')
      set(CURLOPT_CAINFO, bundle);
    if (request.head) set(CURLOPT_NOBODY, 1L);
    if (request.last_bytes > 0) {
      set(CURLOPT_RANGE, ("-" + std::to_string(request.last_bytes)).c_str());
    } else if (request.range) {
      ZC_CHECK(request.range->bytes > 0);
      set(CURLOPT_RANGE,
          (std::to_string(request.range->first) + "-" + std::to_string(request.range->first + request.range->bytes - 1))
              .c_str());
    }
    add_header("Accept-Encoding: identity");
    if (!request.if_range.empty()) add_header("If-Range: " + request.if_range);
    if (!request.if_none_match.empty()) add_header("If-None-Match: " + request.if_none_match);
    set(CURLOPT_HTTPHEADER, headers);
    window_at = Clock::now();
    return true;
  }

  void add_header(const std::string& line) {
    if (curl_slist* longer = curl_slist_append(headers, line.c_str()); longer != nullptr) headers = longer;
  }

  void drop_handles() {
    if (easy != nullptr) curl_easy_cleanup(std::exchange(easy, nullptr));
    if (headers != nullptr) curl_slist_free_all(std::exchange(headers, nullptr));
  }

  [[nodiscard]] bool ranged() const { return request.range || request.last_bytes > 0; }

  [[nodiscard]] long status() const {
    long value = 0;
    curl_easy_getinfo(easy, CURLINFO_RESPONSE_CODE, &value);
    return value;
  }

  [[nodiscard]] Error error(std::string what, ErrorCode code = ErrorCode::kTransient) const {
    Error out{code, std::move(what), request.name};
    if (code != ErrorCode::kTransient) out.retry_after_s = kLongestRetryDelay_s;
    return out;
  }

  [[nodiscard]] std::optional<Error> status_error() const {
    const long code = status();
    if (code == 200 || code == 206 || code == 304) return std::nullopt;
    const bool later = code == 408 || code == 425 || code == 429 || code >= 500;
    Error out =
        error("the server answers with status " + std::to_string(code), later ? ErrorCode::kTransient : ErrorCode::kIo);
    curl_off_t after_s = 0;
    if (later && curl_easy_getinfo(easy, CURLINFO_RETRY_AFTER, &after_s) == CURLE_OK)
      out.retry_after_s = std::clamp(static_cast<double>(after_s), 0.0, kRetryAfterLimit_s);
    return out;
  }

  // When all headers of the last answer are there: whether its body may come.
  [[nodiscard]] std::optional<Error> check_head() {
    const long code = status();
    if (!encoding.empty() && encoding != "identity")
      return error("the server sends it encoded as " + encoding, ErrorCode::kIo);
    if (code == 304 && request.if_none_match.empty()) return error("the server answers with status 304 unasked");
    if (code == 200 && ranged() && !request.head) {
      if (!request.if_range.empty() && answer.etag != request.if_range)
        return error("changed on the server since it was opened", ErrorCode::kIo);
      return error("the server does not answer requests for a range", ErrorCode::kIo);
    }
    if (code == 206) {
      const std::optional<ContentRange> got = parse_content_range(content_range);
      if (!ranged() || !got || !fits(*got))
        return error("the server sends another range than asked for: '" + content_range + "'");
      answer.first_byte = got->first;
      answer.file_bytes = got->file_bytes;
      expected = got->last - got->first + 1;
    } else if (code == 200) {
      expected = length;
      answer.file_bytes = length.value_or(0);
    }
    if (request.head || code == 304) return std::nullopt;
    const std::uint64_t announced = std::max(expected.value_or(0), length.value_or(0));
    if (announced > request.limit_bytes) return too_long();
    answer.body.reserve(std::min<std::uint64_t>(announced, kReserveLimitBytes));
    return std::nullopt;
  }

  // A range may end early only where the file does.
  [[nodiscard]] bool fits(const ContentRange& got) const {
    if (request.last_bytes > 0) return got.last - got.first < request.last_bytes && got.last + 1 == got.file_bytes;
    const std::uint64_t last = request.range->first + request.range->bytes - 1;
    return got.first == request.range->first &&
           (got.last == last || (got.last < last && got.last + 1 == got.file_bytes));
  }

  [[nodiscard]] Error too_long() const {
    return {ErrorCode::kFormat, "the server sends more than " + std::to_string(request.limit_bytes) + " bytes",
            request.name};
  }

  void take_header(std::string_view line) {
    if (line.starts_with("HTTP/")) {  // of the next answer: after a redirection or an interim one
      answer = {};
      content_range.clear();
      encoding.clear();
      length.reset();
      return;
    }
    const std::size_t colon = line.find(':');
    if (colon == std::string_view::npos) return;
    const std::string key = lower(line.substr(0, colon));
    const std::string_view value = trimmed(line.substr(colon + 1));
    if (value.size() > kValueLimitBytes) return;
    if (key == "etag") answer.etag = value;
    if (key == "last-modified") answer.last_modified = value;
    if (key == "content-range") content_range = value;
    if (key == "content-encoding") encoding = lower(value);
    if (key == "content-length") {
      std::string_view digits = value;
      length = take_number(digits);
      if (!digits.empty()) length.reset();
    }
  }

  // Both return less than they got to end the transfer.
  static std::size_t on_header(char* data, std::size_t, std::size_t bytes, void* self) {
    return static_cast<State*>(self)->guard(bytes, [&](State& state) {
      state.window_bytes += bytes;
      state.header_bytes += bytes;
      const std::string_view line(data, bytes);
      if (state.header_bytes > kHeaderLimitBytes) {
        state.fault = state.error("the server sends headers without end");
      } else if (!trimmed(line).empty()) {
        state.take_header(line);
      } else if (const long code = state.status(); code == 200 || code == 206 || code == 304) {
        state.fault = state.check_head();
      }
      return !state.fault;
    });
  }

  static std::size_t on_body(char* data, std::size_t, std::size_t bytes, void* self) {
    return static_cast<State*>(self)->guard(bytes, [&](State& state) {
      state.window_bytes += bytes;
      state.body_bytes += bytes;
      if (state.status_error()) return state.body_bytes <= kErrorBodyLimitBytes;
      std::vector<std::byte>& body = state.answer.body;
      if (bytes > state.request.limit_bytes - body.size()) {
        state.fault = state.too_long();
        return false;
      }
      const auto* from = reinterpret_cast<const std::byte*>(data);
      body.insert(body.end(), from, from + bytes);
      return true;
    });
  }

  // No exception may pass through C.
  template <class F>
  std::size_t guard(std::size_t bytes, F&& start_queued) {
    try {
      return start_queued(*this) ? bytes : bytes == 0 ? 1 : 0;
    } catch (const std::exception& exception) {
      fault = error(exception.what());
      return bytes == 0 ? 1 : 0;
    }
  }

  [[nodiscard]] bool stalled(double timeout_s) {
    if (Clock::now() - window_at < std::chrono::duration<double>(timeout_s)) return false;
    if (window_bytes < kLeastBytes) return true;
    window_at = Clock::now();
    window_bytes = 0;
    return false;
  }

  Result<HttpAnswer> conclude(CURLcode code) {
    if (fault) return *std::move(fault);
    const bool reached = code == CURLE_OK || code == CURLE_WRITE_ERROR;  // ours, at a long body of an error
    if (reached)
      if (std::optional<Error> refused = status_error()) return *std::move(refused);
    if (code != CURLE_OK) {
      const std::string what = text[0] != '\0' ? std::string(text.data()) : std::string(curl_easy_strerror(code));
      return error(what, passes(code) ? ErrorCode::kTransient : ErrorCode::kIo);
    }
    answer.status = static_cast<int>(status());
    if (answer.status != 304 && !request.head && expected && answer.body.size() != *expected)
      return error("the server sends " + std::to_string(answer.body.size()) + " bytes of " + std::to_string(*expected));
    return std::move(answer);
  }

  HttpClient::Impl& client;
  const HttpRequest request;
  CURL* easy = nullptr;
  curl_slist* headers = nullptr;
  std::array<char, CURL_ERROR_SIZE> text = {};
  HttpAnswer answer;
  std::string content_range, encoding;
  std::optional<std::uint64_t> length, expected;  // as announced; what the body must have
  std::optional<Error> fault;                     // why a callback ended the transfer
  std::uint64_t header_bytes = 0, body_bytes = 0;
  Clock::time_point window_at;
  std::uint64_t window_bytes = 0;  // since then

  // --- any thread ---

  void publish(Result<HttpAnswer> outcome) {
    const std::lock_guard lock(mutex);
    result = std::move(outcome);
    done.notify_all();
  }

  std::atomic<bool> cancelled = false;
  std::mutex mutex;
  std::condition_variable done;
  std::optional<Result<HttpAnswer>> result;
};

class HttpClient::Impl {
 public:
  using State = Download::State;

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

  void submit(std::shared_ptr<State> state) {
    {
      const std::lock_guard lock(mutex_);
      queue_.push_back(std::move(state));
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
        State* state = nullptr;
        curl_easy_getinfo(message->easy_handle, CURLINFO_PRIVATE, &state);
        finish(*state, state->conclude(message->data.result));
      }
      reap();
      if (!may_begin()) curl_multi_poll(multi_, nullptr, 0, poll_ms(), nullptr);
    }
  }

  // Begins what waits; false when the thread is to end.
  bool start_queued() {
    std::vector<std::shared_ptr<State>> fresh, dropped;
    {
      const std::lock_guard lock(mutex_);
      if (stop_ && queue_.empty() && active_.empty()) return false;
      for (auto state = queue_.begin(); state != queue_.end();) {  // whatever its place in the queue
        if (!(*state)->cancelled) {
          ++state;
          continue;
        }
        dropped.push_back(std::move(*state));
        state = queue_.erase(state);
      }
      while (active_.size() + fresh.size() < kMostAtOnce && !queue_.empty()) {
        fresh.push_back(std::move(queue_.front()));
        queue_.pop_front();
      }
      counts_.requests += fresh.size();
    }
    for (const auto& state : dropped) state->publish(cancelled(*state));
    for (auto& state : fresh) {
      active_.push_back(state);
      if (!state->prepare(timeout_s_) || curl_multi_add_handle(multi_, state->easy) != CURLM_OK)
        finish(*state, state->error("out of memory"));
    }
    return true;
  }

  // Whether something waits that what has ended makes room for.
  [[nodiscard]] bool may_begin() const {
    const std::lock_guard lock(mutex_);
    return !queue_.empty() && active_.size() < kMostAtOnce;
  }

  void reap() {
    const std::vector<std::shared_ptr<State>> now = active_;
    for (const auto& state : now) {
      if (state->cancelled) {
        finish(*state, cancelled(*state));
      } else if (state->stalled(timeout_s_)) {
        finish(*state, state->error("the server stalls"));
      }
    }
  }

  static Error cancelled(const State& state) { return state.error("given up"); }

  void finish(State& state, Result<HttpAnswer> outcome) {
    if (state.easy != nullptr) curl_multi_remove_handle(multi_, state.easy);
    state.drop_handles();
    {
      const std::lock_guard lock(mutex_);
      counts_.bytes_received += state.body_bytes;
      if (!outcome.ok() && !state.cancelled) ++counts_.failed;
      if (outcome.ok() && outcome->status == 304) ++counts_.not_modified;
    }
    const auto found = std::ranges::find_if(active_, [&](const auto& other) { return other.get() == &state; });
    ZC_CHECK(found != active_.end());
    const std::shared_ptr<State> kept = std::move(*found);
    active_.erase(found);
    if (!outcome.ok()) state.answer = {};
    kept->publish(std::move(outcome));
  }

  [[nodiscard]] int poll_ms() const {
    if (active_.empty()) return 60'000;  // until it is woken
    auto next = Clock::now() + std::chrono::seconds(1);
    for (const auto& state : active_)
      next = std::min(next, state->window_at +
                                std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(timeout_s_)));
    const auto ms = std::chrono::duration_cast<std::chrono::milliseconds>(next - Clock::now()).count();
    return static_cast<int>(std::max<std::int64_t>(ms + 1, 0));
  }

  CURLM* const multi_;
  const double timeout_s_;
  mutable std::mutex mutex_;
  std::deque<std::shared_ptr<State>> queue_;
  HttpCounts counts_;
  bool stop_ = false;
  std::vector<std::shared_ptr<State>> active_;  // the thread's own
  std::thread thread_;
};

HttpClient::Download::~Download() {
  if (!state_) return;
  cancel();
  (void)wait();  // its memory is the network thread's until then
}

const Result<HttpAnswer>& HttpClient::Download::wait() {
  std::unique_lock lock(state_->mutex);
  state_->done.wait(lock, [&] { return state_->result.has_value(); });
  return *state_->result;
}

void HttpClient::Download::cancel() {
  state_->cancelled = true;
  state_->client.wake();
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
  auto state = std::make_shared<Download::State>(*impl_, std::move(request));
  impl_->submit(state);
  return Download(std::move(state));
}

Result<HttpAnswer> HttpClient::fetch(HttpRequest request) {
  Download download = start(std::move(request));
  (void)download.wait();
  return std::move(*download.state_->result);
}

HttpCounts HttpClient::counts() const { return impl_->counts(); }

}  // namespace zc
