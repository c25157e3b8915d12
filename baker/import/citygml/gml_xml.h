// SPDX-License-Identifier: GPL-3.0-or-later
// What the importer asks of an XML element: names without their prefixes, the namespace of a root, lists of numbers,
// the place of a fault. Borrows the document. Untrusted input. Thread-safe: no state.
#pragma once

#include <pugixml.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"

namespace zc {

// The name without its namespace's prefix.
std::string_view local_name(const pugi::xml_node& node);
// The first child or attribute of that local name; an empty one where there is none.
pugi::xml_node gml_child(const pugi::xml_node& node, std::string_view name);
std::string_view gml_attribute(const pugi::xml_node& node, std::string_view name);
std::string_view gml_text(const pugi::xml_node& node);
// Numbers between blanks or commas. Fails on anything else, naming the place.
Result<std::vector<double>> gml_numbers(const pugi::xml_node& node, const std::string& path);
Error gml_error(const pugi::xml_node& node, std::string message, const std::string& path);

// Calls visit(element) for every element of the tree in document order, without recursion: files nest as they like.
// Where it returns false, what is below the element is passed over.
template <class Visit>
void walk_gml(const pugi::xml_node& root, const Visit& visit) {
  for (pugi::xml_node node = root; node;) {
    const bool enters = node.type() == pugi::node_element && visit(node);
    if (enters && node.first_child()) {
      node = node.first_child();
      continue;
    }
    while (node != root && !node.next_sibling()) node = node.parent();
    node = node == root ? pugi::xml_node() : node.next_sibling();
  }
}

// The namespace that the prefix of a document's root stands for; empty where it stands for none.
std::string_view namespace_of_root(const pugi::xml_node& root);

}  // namespace zc
