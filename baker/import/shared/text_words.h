// SPDX-License-Identifier: GPL-3.0-or-later
// Text formats of lines and words (OBJ, MTL, PLY), word by word, without a copy. Borrows the text. Untrusted input.
// Not thread-safe.
#pragma once

#include <cstddef>
#include <optional>
#include <string_view>

namespace zc {

class TextWords {
 public:
  // Before the first line. A backslash at the end of a line joins it with the next one where `joins_lines`.
  TextWords(std::string_view text, bool joins_lines)
      : text_(text), joins_lines_(joins_lines), at_(text.starts_with("\xEF\xBB\xBF") ? 3 : 0) {}

  // The next line that is not empty and no comment (#); false when there is none.
  bool next_line();
  // The next word of the line; empty behind the last and at a comment.
  std::string_view word();
  // The next word of this line or of those behind it; empty at the end of the text.
  std::string_view word_anywhere();
  // What is left of the line, without the blanks around it; a # is part of it.
  std::string_view rest();
  // Of the last word or line, in the text.
  [[nodiscard]] std::size_t offset() const { return offset_; }
  // Of what comes next.
  [[nodiscard]] std::size_t at() const { return at_; }

 private:
  [[nodiscard]] std::size_t joint(std::size_t at) const;

  std::string_view text_;
  bool joins_lines_;
  bool is_begun_ = false;
  std::size_t at_;
  std::size_t offset_ = 0;
};

// A whole word, whatever the locale; infinite where it is beyond a double. Nothing of any other text ("1,5").
std::optional<double> number_of(std::string_view word);
std::optional<long long> integer_of(std::string_view word);

}  // namespace zc
