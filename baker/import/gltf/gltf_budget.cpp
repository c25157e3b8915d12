// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/import/gltf/gltf_budget.h"

namespace zc {

Error GltfBudget::beyond(const std::string& what, const Sum& sum, const std::string& next_step) const {
  return {ErrorCode::kUnsupported,
          what + ": a glTF file of " + std::to_string(bytes_) + " bytes may have " + std::to_string(sum.most) +
              " in all; " + next_step,
          path_};
}

Status GltfBudget::read(std::uint64_t elements, bool bare, const std::string& where) {
  const std::string what = where + " has " + std::to_string(elements) + " more elements";
  if (bare && !bare_.add(elements))
    return beyond(what + " without bytes of their own", bare_, "write accessors with a bufferView");
  if (!read_.add(elements)) return beyond(what + " to read", read_, "give each primitive accessors of its own");
  return {};
}

Status GltfBudget::keep(std::uint64_t elements, const std::string& where) {
  if (kept_.add(elements)) return {};
  return beyond(where + " adds " + std::to_string(elements) + " vertices and triangles", kept_,
                "let nodes share meshes, or split the file");
}

Status GltfBudget::draw(std::uint64_t triangles, std::uint64_t times, const std::string& where) {
  if (triangles == 0 || times == 0) return {};
  if (times <= (drawn_.most - drawn_.done) / triangles) {
    drawn_.done += triangles * times;
    return {};
  }
  return beyond(where + " shows " + std::to_string(triangles) + " triangles " + std::to_string(times) +
                    (times == 1 ? " time, after " : " times, after ") + std::to_string(drawn_.done) + " of other nodes",
                drawn_, "split the file, or leave out instances");
}

}  // namespace zc
