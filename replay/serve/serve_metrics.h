// SPDX-License-Identifier: Apache-2.0
// What a server did since it started, and the same as Prometheus reads it (text format 0.0.4). Threads: any.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <mutex>
#include <string>

namespace zc {

class ServeMetrics {
 public:
  void begin_request();
  void end_request(int code, std::uint64_t bytes, double seconds);
  void open_connection();
  void close_connection();
  void refuse_connection();

  [[nodiscard]] std::uint64_t in_flight() const;
  [[nodiscard]] std::string prometheus() const;

 private:
  static constexpr std::array<double, 10> kBounds_s = {0.0005, 0.001, 0.0025, 0.005, 0.01, 0.05, 0.1, 0.5, 1, 10};

  mutable std::mutex mutex_;
  std::map<int, std::uint64_t> requests_;                     // by code
  std::array<std::uint64_t, kBounds_s.size() + 1> within_{};  // each its own; the last beyond all bounds
  std::uint64_t count_ = 0, bytes_ = 0, in_flight_ = 0, connections_ = 0, refused_ = 0;
  double seconds_ = 0;
};

}  // namespace zc
