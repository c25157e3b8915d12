// SPDX-License-Identifier: Apache-2.0
#include "replay/serve/serve_metrics.h"

#include <algorithm>
#include <sstream>

namespace zc {

void ServeMetrics::begin_request() {
  const std::lock_guard lock(mutex_);
  ++in_flight_;
}

void ServeMetrics::end_request(int code, std::uint64_t bytes, double seconds) {
  const std::lock_guard lock(mutex_);
  --in_flight_;
  ++requests_[code];
  ++count_;
  bytes_ += bytes;
  seconds_ += seconds;
  const auto bound = std::ranges::lower_bound(kBounds_s, seconds);
  ++within_[static_cast<std::size_t>(bound - kBounds_s.begin())];
}

void ServeMetrics::open_connection() {
  const std::lock_guard lock(mutex_);
  ++connections_;
}

void ServeMetrics::close_connection() {
  const std::lock_guard lock(mutex_);
  --connections_;
}

void ServeMetrics::refuse_connection() {
  const std::lock_guard lock(mutex_);
  ++refused_;
}

std::uint64_t ServeMetrics::in_flight() const {
  const std::lock_guard lock(mutex_);
  return in_flight_;
}

std::string ServeMetrics::prometheus() const {
  const std::lock_guard lock(mutex_);
  std::ostringstream out;
  const auto head = [&](const char* name, const char* kind, const char* help) {
    out << "# HELP zonecast_http_" << name << ' ' << help << "\n# TYPE zonecast_http_" << name << ' ' << kind << '\n';
  };
  const auto line = [&](const char* name, const char* kind, const char* help, std::uint64_t value) {
    head(name, kind, help);
    out << "zonecast_http_" << name << ' ' << value << '\n';
  };
  head("requests_total", "counter", "Requests answered, by status.");
  for (const auto& [code, count] : requests_)
    out << "zonecast_http_requests_total{code=\"" << code << "\"} " << count << '\n';
  const auto kept = requests_.find(304);
  line("cache_hits_total", "counter", "Requests whose copy was still right (304).",
       kept == requests_.end() ? 0 : kept->second);
  line("sent_bytes_total", "counter", "Bytes sent, headers included.", bytes_);
  line("in_flight", "gauge", "Requests being answered.", in_flight_);
  line("connections", "gauge", "Open connections.", connections_);
  line("refused_connections_total", "counter", "Connections refused because there were too many.", refused_);
  head("request_duration_seconds", "histogram", "From a request's last header to its answer's last byte.");
  std::uint64_t sum = 0;
  for (std::size_t i = 0; i < kBounds_s.size(); ++i) {
    sum += within_[i];
    out << "zonecast_http_request_duration_seconds_bucket{le=\"" << kBounds_s[i] << "\"} " << sum << '\n';
  }
  out << "zonecast_http_request_duration_seconds_bucket{le=\"+Inf\"} " << count_ << '\n'
      << "zonecast_http_request_duration_seconds_sum " << seconds_ << '\n'
      << "zonecast_http_request_duration_seconds_count " << count_ << '\n';
  return out.str();
}

}  // namespace zc
