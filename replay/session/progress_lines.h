// SPDX-License-Identifier: Apache-2.0
// What a log says of long work: a line when a stage ends, and one each ten seconds in between, with the rate and the
// time that is left. Whoever calls it has the clock and prints. Units: seconds since the work began. Threads: one.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace zc {

// Of the things that the work is made of, where they are counted.
struct ProgressCount {
  std::uint64_t done = 0;
  std::uint64_t all = 0;  // 0: not counted
  std::string_view what = {};
};

class ProgressLines {
 public:
  static constexpr double kInterval_s = 10;

  // No line before `first_s`: short work needs none.
  explicit ProgressLines(double first_s = 0) : first_s_(first_s) {}

  // fraction: of all stages, 0 to 1. The lines to print.
  std::vector<std::string> update(double now_s, double fraction, std::string_view stage,
                                  const ProgressCount& count = {});
  // The last stage's, once it is through.
  std::vector<std::string> finish(double now_s);

 private:
  void end_stage(double now_s, std::vector<std::string>& lines);

  double first_s_;
  std::string stage_;
  double stage_began_s_ = 0;
  double said_s_ = 0;
  double fraction_ = 0;
};

}  // namespace zc
