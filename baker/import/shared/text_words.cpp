// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/import/shared/text_words.h"

#include <charconv>
#include <limits>

namespace zc {
namespace {

constexpr std::string_view kBlanks = " \t\v\f";
constexpr std::string_view kEnds = "\r\n";

bool is_blank(char c) { return kBlanks.find(c) != std::string_view::npos; }
bool is_end(char c) { return kEnds.find(c) != std::string_view::npos; }

}  // namespace

// How many bytes join two lines here.
std::size_t TextWords::joint(std::size_t at) const {
  if (!joins_lines_ || text_[at] != '\\') return 0;
  const std::string_view behind = text_.substr(at + 1, 2);
  if (behind == "\r\n") return 3;
  return !behind.empty() && is_end(behind[0]) ? 2 : 0;
}

bool TextWords::next_line() {
  // The rest of the line before; nothing of it at the start.
  for (; is_begun_ && at_ < text_.size() && !is_end(text_[at_]); ++at_)
    if (const std::size_t bytes = joint(at_); bytes > 0) at_ += bytes - 1;
  is_begun_ = true;
  for (; at_ < text_.size(); ++at_) {
    if (is_blank(text_[at_]) || is_end(text_[at_])) continue;
    if (text_[at_] != '#') break;
    at_ = text_.find_first_of(kEnds, at_);
    if (at_ == std::string_view::npos) at_ = text_.size() - 1;
  }
  offset_ = at_;
  return at_ < text_.size();
}

std::string_view TextWords::word() {
  while (at_ < text_.size()) {
    if (is_blank(text_[at_]))
      ++at_;
    else if (const std::size_t bytes = joint(at_); bytes > 0)
      at_ += bytes;
    else
      break;
  }
  const std::size_t start = at_;
  if (at_ < text_.size() && text_[at_] == '#') return {};
  while (at_ < text_.size() && !is_blank(text_[at_]) && !is_end(text_[at_]) && joint(at_) == 0) ++at_;
  if (at_ > start) offset_ = start;
  return text_.substr(start, at_ - start);
}

std::string_view TextWords::word_anywhere() {
  std::string_view found = word();
  while (found.empty() && next_line()) found = word();
  return found;
}

std::string_view TextWords::rest() {
  while (at_ < text_.size() && is_blank(text_[at_])) ++at_;
  const std::size_t start = at_;
  while (at_ < text_.size() && !is_end(text_[at_])) ++at_;
  std::size_t end = at_;
  while (end > start && is_blank(text_[end - 1])) --end;
  return text_.substr(start, end - start);
}

std::optional<double> number_of(std::string_view word) {
  if (word.starts_with('+')) word.remove_prefix(1);
  double value = 0;
  const auto [end, failure] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (word.empty() || end != word.data() + word.size()) return std::nullopt;
  if (failure == std::errc::result_out_of_range)
    return word.find("e-") != std::string_view::npos || word.find("E-") != std::string_view::npos
               ? 0.0
               : std::numeric_limits<double>::infinity();
  if (failure != std::errc()) return std::nullopt;
  return value;
}

std::optional<long long> integer_of(std::string_view word) {
  if (word.starts_with('+')) word.remove_prefix(1);
  long long value = 0;
  const auto [end, failure] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (word.empty() || end != word.data() + word.size() || failure != std::errc()) return std::nullopt;
  return value;
}

}  // namespace zc
