// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/import/citygml/gml_xml.h"

#include <charconv>
#include <cstdint>

#include "baker/import/shared/json_text.h"

namespace zc {

std::string_view local_name(const pugi::xml_node& node) {
  const std::string_view name = node.name();
  const std::size_t colon = name.find(':');
  return colon == std::string_view::npos ? name : name.substr(colon + 1);
}

pugi::xml_node gml_child(const pugi::xml_node& node, std::string_view name) {
  for (const pugi::xml_node& child : node.children())
    if (local_name(child) == name) return child;
  return {};
}

std::string_view gml_attribute(const pugi::xml_node& node, std::string_view name) {
  for (const pugi::xml_attribute& attribute : node.attributes()) {
    const std::string_view full = attribute.name();
    const std::size_t colon = full.find(':');
    if ((colon == std::string_view::npos ? full : full.substr(colon + 1)) == name) return attribute.value();
  }
  return {};
}

std::string_view gml_text(const pugi::xml_node& node) {
  std::string_view text = node.child_value();
  const std::string_view blank = " \t\r\n";
  const std::size_t first = text.find_first_not_of(blank);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(blank) - first + 1);
}

Error gml_error(const pugi::xml_node& node, std::string message, const std::string& path) {
  return {ErrorCode::kFormat, std::move(message), path, static_cast<std::int64_t>(node.offset_debug())};
}

Result<std::vector<double>> gml_numbers(const pugi::xml_node& node, const std::string& path) {
  std::vector<double> numbers;
  for (const pugi::xml_node& part : node.children()) {  // several where comments lie between
    const std::string_view text = part.value();
    for (std::size_t at = 0; at < text.size();) {
      if (std::string_view(" \t\r\n,").find(text[at]) != std::string_view::npos) {
        ++at;
        continue;
      }
      const char* begin = text.data() + at + (text[at] == '+' ? 1 : 0);
      double value = 0;
      const auto [end, failure] = std::from_chars(begin, text.data() + text.size(), value);
      if (failure != std::errc())
        return gml_error(node, "'" + one_line(text.substr(at, 24)) + "' in " + one_line(node.name()) + " is no number",
                         path);
      numbers.push_back(value);
      at = static_cast<std::size_t>(end - text.data());
    }
  }
  return numbers;
}

std::string_view namespace_of_root(const pugi::xml_node& root) {
  const std::string_view name = root.name();
  const std::size_t colon = name.find(':');
  const std::string declaration =
      colon == std::string_view::npos ? "xmlns" : "xmlns:" + std::string(name.substr(0, colon));
  return root.attribute(declaration.c_str()).value();
}

}  // namespace zc
