// SPDX-License-Identifier: Apache-2.0
#include "replay/cli/help_format.h"

#include <algorithm>
#include <sstream>

namespace zc {
namespace {

constexpr std::size_t kWidth = 110;
constexpr std::size_t kColumn = 30;  // where descriptions begin

// The words of `text` in lines, each behind `indent` spaces; `used` columns of the first line are taken.
std::string wrap(const std::string& text, std::size_t indent, std::size_t used) {
  std::istringstream words(text);
  std::string out, word;
  std::size_t column = used;
  for (bool first = true; words >> word; first = false) {
    if (!first && column + 1 + word.size() > kWidth) {
      out += '\n';
      column = 0;
      first = true;
    }
    const std::size_t gap = first ? indent - std::min(indent, column) : 1;
    out += std::string(gap, ' ') + word;
    column += gap + word.size();
  }
  return out + '\n';
}

// A name, and behind it, or below it where it is long, what it means.
std::string entry(const std::string& name, const std::string& text) {
  const std::string head = "  " + name;
  if (text.empty()) return head + '\n';
  const bool fits = head.size() + 2 <= kColumn;
  return head + (fits ? "" : "\n") + wrap(text, kColumn, fits ? head.size() : 0);
}

}  // namespace

std::string HelpFormat::make_description(const CLI::App* app) const { return wrap(app->get_description(), 0, 0); }

std::string HelpFormat::make_footer(const CLI::App* app) const {
  return app->get_footer().empty() ? std::string() : wrap(app->get_footer(), 0, 0);
}

std::string HelpFormat::make_subcommand(const CLI::App* sub) const {
  return entry(sub->get_name(), sub->get_description());
}

std::string HelpFormat::make_option(const CLI::Option* option, bool is_positional) const {
  std::string name = make_option_name(option, is_positional);
  name.erase(std::min(name.find('{'), name.size()));  // the value of a flag that turns something off
  return entry(name + make_option_opts(option), make_option_desc(option));
}

std::string HelpFormat::make_option_opts(const CLI::Option* option) const {
  if (!option->get_option_text().empty()) return ' ' + option->get_option_text();
  if (option->get_type_size() == 0) return {};
  const std::string type = option->get_type_name();  // with what values may be, behind a colon
  std::string out = ' ' + type.substr(0, type.find(':'));
  if (!option->get_default_str().empty()) out += '=' + option->get_default_str();
  if (option->get_expected_max() == CLI::detail::expected_max_vector_size) out += " ...";
  return out + (option->get_required() ? " REQUIRED" : "");
}

}  // namespace zc
