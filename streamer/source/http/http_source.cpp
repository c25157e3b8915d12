// SPDX-License-Identifier: Apache-2.0
#include "streamer/source/http/http_source.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "streamer/source/archive_index.h"
#include "streamer/source/http/response_rules.h"
#include "streamer/source/http/web_address.h"
#include "streamer/source/http/web_world.h"
#include "streamer/source/retry.h"
#include "streamer/world_format/world_index.h"

namespace zc {
namespace {

class WebFolder final : public WebWorld {
 public:
  using WebWorld::WebWorld;

  Result<std::vector<std::byte>> read_all(const std::string& name, std::uint64_t limit_bytes) override {
    ZC_ASSIGN(HttpRequest request, request_for(name, limit_bytes));
    const std::string etag_key = request.name + "\nETag";
    if (cache() != nullptr) {
      if (const auto kept = cache()->get(etag_key, kEtagLimitBytes)) {
        request.if_none_match.assign(reinterpret_cast<const char*>(kept->data()), kept->size());
        if (!cache()->has(body_key(request, request.if_none_match))) request.if_none_match.clear();
      }
    }
    ZC_ASSIGN(HttpAnswer answer, with_retries([&] { return client().fetch(request); }));
    if (answer.status == 304) {
      if (auto kept = cache()->get(body_key(request, request.if_none_match), limit_bytes)) {
        answer.body = *std::move(kept);
        answer.etag = request.if_none_match;
      } else {
        request.if_none_match.clear();
        ZC_ASSIGN(answer, with_retries([&] { return client().fetch(request); }));
      }
    }
    answer.file_bytes = answer.body.size();
    if (name == kWorldIndexName) ZC_TRY(watch(answer));
    if (answer.status == 200 && cache() != nullptr && strong_etag(answer.etag)) {
      cache()->put(body_key(request, answer.etag), answer.body);
      cache()->put(etag_key, std::as_bytes(std::span(answer.etag)));
    }
    return std::move(answer.body);
  }

 private:
  static constexpr std::uint64_t kEtagLimitBytes = 1024;

  [[nodiscard]] Result<Plan> plan(std::span<const WantedFile> files) const override {
    Plan plan;
    for (const WantedFile& file : files) {
      ZC_ASSIGN(HttpRequest request, request_for(file.name, file.bytes));
      plan.request_of.push_back(plan.requests.size());
      plan.requests.push_back(std::move(request));
    }
    return plan;
  }

  [[nodiscard]] Result<std::span<const std::byte>> cut(const HttpAnswer& answer, const WantedFile&) const override {
    return std::span<const std::byte>(answer.body);
  }

  [[nodiscard]] Result<HttpRequest> request_for(const std::string& name, std::uint64_t limit_bytes) const {
    ZC_TRY(check_name(name));
    ZC_ASSIGN(std::string address, url_below(url(), name));
    return HttpRequest{.url = address, .name = public_url(address), .limit_bytes = limit_bytes};
  }

  static std::string body_key(const HttpRequest& request, const std::string& etag) {
    return request.name + '\n' + etag + "\nwhole";
  }
};

class WebArchive final : public WebWorld {
 public:
  using WebWorld::WebWorld;

  // Once, before everything else. Fails when the index is larger than most_bytes.
  Status find_index(std::uint64_t most_bytes) {
    const HttpRequest request{
        .url = url(), .name = shown_url(), .last_bytes = kArchiveTailBytes, .limit_bytes = kArchiveTailBytes};
    ZC_ASSIGN(const HttpAnswer tail, with_retries([&] { return client().fetch(request); }));
    ZC_TRY(watch(tail));
    etag_ = tail.etag;
    bytes_ = tail.file_bytes;
    const auto header_at = find_archive_index(tail.body);
    if (!header_at) return fault(kArchiveIndexName, header_at.error());
    ZC_ASSIGN(const Place place, place_at(*header_at, kArchiveIndexName));
    if (place.bytes % kArchiveEntryBytes != 0)
      return Error{ErrorCode::kFormat, "its index is no list of entries: not a 3D Tiles archive", shown_url()};
    if (place.bytes > most_bytes)
      return fault(kArchiveIndexName, "is " + std::to_string(place.bytes) + " bytes, more than the " +
                                          std::to_string(most_bytes) + " that it may take of the memory");
    if (place.bytes == 0) return {};
    ZC_ASSIGN(const std::vector<std::byte> list, range({place.offset, place.bytes}, kArchiveIndexName));
    entries_.resize(list.size() / kArchiveEntryBytes);
    std::copy(list.begin(), list.end(), std::as_writable_bytes(std::span(entries_)).begin());
    return {};
  }

  Result<std::vector<std::byte>> read_all(const std::string& name, std::uint64_t limit_bytes) override {
    ZC_ASSIGN(const std::uint64_t header_at, find(name));
    ZC_ASSIGN(const Place place, place_at(header_at, name));
    if (place.bytes > limit_bytes)
      return fault(name, "is " + std::to_string(place.bytes) + " bytes, more than " + std::to_string(limit_bytes));
    if (place.bytes == 0) return std::vector<std::byte>();
    return range({place.offset, place.bytes}, name);
  }

  [[nodiscard]] SourceCosts costs() const override { return {.held_bytes = entries_.size() * sizeof(ArchiveEntry)}; }

 private:
  struct Place {
    std::uint64_t offset = 0;
    std::uint64_t bytes = 0;
  };
  // Read behind a local header, for what fields it may carry behind its name.
  static constexpr std::uint64_t kFieldBytes = 512;
  // A request more costs more than to read this and drop it.
  static constexpr std::uint64_t kGapBytes = 4096;

  [[nodiscard]] Error fault(const std::string& name, Error error) const {
    error.path = shown_url() + ": " + name;
    return error;
  }
  [[nodiscard]] Error fault(const std::string& name, std::string what, ErrorCode code = ErrorCode::kFormat) const {
    return fault(name, Error{code, std::move(what)});
  }

  Result<std::vector<std::byte>> range(HttpRange where, const std::string& name) {
    return read_range_of(url(), shown_url() + ": " + name, where, etag_);
  }

  // Where the local header of the first file with this name's hash is.
  [[nodiscard]] Result<std::uint64_t> find(const std::string& name) const {
    const ArchiveKey key = archive_key(name);
    const auto found = std::ranges::lower_bound(entries_, key, {}, &ArchiveEntry::key);
    if (found == entries_.end() || found->key != key) return fault(name, "is not in the archive", ErrorCode::kIo);
    if (found->offset >= bytes_) return fault(name, "lies outside the archive");
    return found->offset;
  }

  // A file's header, its data, and what may lie between.
  [[nodiscard]] HttpRange range_of(std::uint64_t header_at, const std::string& name, std::uint64_t bytes) const {
    const std::uint64_t rest = bytes_ - header_at;
    return {header_at, std::min(rest, kLocalHeaderBytes + name.size() + kFieldBytes + std::min(bytes, rest))};
  }

  Result<Place> place_at(std::uint64_t header_at, const std::string& name) {
    if (header_at >= bytes_) return fault(name, "lies outside the archive");
    const HttpRange where = range_of(header_at, name, 0);
    ZC_ASSIGN(const std::vector<std::byte> front, range(where, name));
    return place_in(front, header_at, name);
  }

  // `front`: the archive's bytes from header_at on.
  [[nodiscard]] Result<Place> place_in(std::span<const std::byte> front, std::uint64_t header_at,
                                       const std::string& name) const {
    const auto header = read_local_header(front);
    if (!header) return fault(name, header.error());
    if (header->name != name) return fault(name, "is not in the archive", ErrorCode::kIo);
    const std::uint64_t data = header_at + header->data_at;
    if (data > bytes_ || header->bytes > bytes_ - data) return fault(name, "lies outside the archive");
    return Place{data, header->bytes};
  }

  [[nodiscard]] Result<Plan> plan(std::span<const WantedFile> files) const override {
    struct Piece {
      HttpRange range;
      std::size_t file = 0;
    };
    std::vector<Piece> pieces;
    for (std::size_t i = 0; i < files.size(); ++i) {
      ZC_ASSIGN(const std::uint64_t header_at, find(files[i].name));
      pieces.push_back({range_of(header_at, files[i].name, files[i].bytes), i});
    }
    std::ranges::sort(pieces, {}, [](const Piece& piece) { return piece.range.first; });
    Plan plan;
    plan.request_of.resize(files.size());
    for (const Piece& piece : pieces) {
      const std::uint64_t end = piece.range.first + piece.range.bytes;
      HttpRange* last = plan.requests.empty() ? nullptr : &*plan.requests.back().range;
      if (last != nullptr && piece.range.first <= last->first + last->bytes + kGapBytes) {
        last->bytes = std::max(last->first + last->bytes, end) - last->first;
        plan.requests.back().limit_bytes = last->bytes;
      } else {
        plan.requests.push_back({.url = url(),
                                 .name = shown_url() + ": " + files[piece.file].name,
                                 .range = piece.range,
                                 .if_range = strong_etag(etag_) ? etag_ : std::string(),
                                 .limit_bytes = piece.range.bytes});
      }
      plan.request_of[piece.file] = plan.requests.size() - 1;
    }
    return plan;
  }

  [[nodiscard]] Result<std::span<const std::byte>> cut(const HttpAnswer& answer,
                                                       const WantedFile& file) const override {
    ZC_ASSIGN(const std::uint64_t header_at, find(file.name));
    const std::span<const std::byte> body = answer.body;
    const std::uint64_t at = header_at - answer.first_byte;
    if (header_at < answer.first_byte || at > body.size()) return fault(file.name, "is not in the answer");
    ZC_ASSIGN(const Place place, place_in(body.subspan(at), header_at, file.name));
    if (place.bytes != file.bytes)
      return fault(file.name,
                   "is " + std::to_string(place.bytes) + " bytes, the index says " + std::to_string(file.bytes));
    const std::uint64_t data = place.offset - answer.first_byte;
    if (data > body.size() || place.bytes > body.size() - data)
      return fault(file.name, "has more than its name in its header", ErrorCode::kUnsupported);
    return body.subspan(data, place.bytes);
  }

  std::string etag_;
  std::uint64_t bytes_ = 0;
  std::vector<ArchiveEntry> entries_;
};

bool names_archive(const std::string& url) { return public_url(url).ends_with(".3tz"); }

}  // namespace

Result<std::unique_ptr<Source>> open_http_source(const std::string& url, const SourceOptions& options) {
  ZC_ASSIGN(const std::string index_url, url_below(url, kWorldIndexName));
  ZC_ASSIGN(std::unique_ptr<HttpClient> client, HttpClient::create(options.timeout_s));
  std::unique_ptr<DiskCache> cache;
  if (!options.cache.empty()) {
    ZC_ASSIGN(cache, DiskCache::open(options.cache, options.cache_bytes));
  }
  if (!names_archive(url))
    return std::unique_ptr<Source>(std::make_unique<WebFolder>(std::move(client), std::move(cache), url, index_url));
  auto archive = std::make_unique<WebArchive>(std::move(client), std::move(cache), url, url);
  ZC_TRY(archive->find_index(options.held_bytes_most));
  return std::unique_ptr<Source>(std::move(archive));
}

}  // namespace zc
