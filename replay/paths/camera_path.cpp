// SPDX-License-Identifier: Apache-2.0
#include "replay/paths/camera_path.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <nlohmann/json.hpp>
#include <string_view>

#include "base/file.h"
#include "base/text.h"

namespace zc {
namespace {

constexpr std::uint64_t kLargestPath = 256ULL << 20U;
constexpr std::string_view kHeader = "time_s,eye_x,eye_y,eye_z,target_x,target_y,target_z,fov_y_deg";

// Empty when the sample is a camera that can be drawn.
std::string fault_of(const CameraSample& sample) {
  for (const double v : {sample.time_s, sample.eye.x, sample.eye.y, sample.eye.z, sample.target.x, sample.target.y,
                         sample.target.z, sample.fov_y_deg}) {
    if (!std::isfinite(v)) return "a value is not a finite number";
    if (std::abs(v) > 1e9) return "a value is beyond 1e9";
  }
  if (sample.fov_y_deg < 1 || sample.fov_y_deg > 170) return "fov_y_deg is not between 1 and 170";
  if (glm::length(sample.target - sample.eye) < 1e-6) return "eye and target are the same point";
  return {};
}

// A view's name becomes a file's.
bool names_a_file(const std::string& name) {
  return !name.empty() && name.size() <= 64 && std::ranges::all_of(name, [](unsigned char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '-';
  });
}

Result<CameraSample> parse_line(std::string_view line) {
  std::array<double, 8> values{};
  const char* at = line.data();
  const char* const end = at + line.size();
  for (std::size_t i = 0; i < values.size(); ++i) {
    const auto [rest, failure] = std::from_chars(at, end, values[i]);
    if (failure != std::errc{}) return Error{ErrorCode::kFormat, "value " + std::to_string(i + 1) + " is not a number"};
    const bool last = i + 1 == values.size();
    if (last ? rest != end : (rest == end || *rest != ','))
      return Error{ErrorCode::kFormat, "expected 8 values separated by commas"};
    at = rest + 1;
  }
  return CameraSample{values[0], {values[1], values[2], values[3]}, {values[4], values[5], values[6]}, values[7]};
}

Result<CameraPath> read_csv(std::string_view text, const std::string& file) {
  CameraPath path;
  std::size_t number = 0;
  take(text, "\xEF\xBB\xBF");  // the byte order mark that spreadsheets write
  while (!text.empty()) {
    const std::size_t length = std::min(text.find('\n'), text.size());
    std::string_view line = text.substr(0, length);
    text.remove_prefix(std::min(length + 1, text.size()));
    if (line.ends_with('\r')) line.remove_suffix(1);
    const auto fault = [&](const std::string& cause) {
      return Error{ErrorCode::kFormat, "line " + std::to_string(number) + ": " + cause, file};
    };
    ++number;
    if (number == 1) {
      if (line != kHeader) return fault("expected the header " + std::string(kHeader));
      continue;
    }
    if (line.empty()) continue;
    auto sample = parse_line(line);
    if (!sample) return fault(sample.error().message);
    if (const std::string cause = fault_of(*sample); !cause.empty()) return fault(cause);
    if (!path.empty() && sample->time_s < path.back().time_s) return fault("time runs backwards");
    path.push_back(*std::move(sample));
  }
  return path;
}

Result<CameraPath> read_shots(std::string_view text, const std::string& file) {
  CameraPath path;
  try {
    const auto document = nlohmann::json::parse(text);
    for (const auto& shot : document.at("shots")) {
      CameraSample sample;
      sample.time_s = static_cast<double>(path.size());
      const auto eye = shot.at("eye").get<std::array<double, 3>>();
      const auto target = shot.at("target").get<std::array<double, 3>>();
      sample.eye = {eye[0], eye[1], eye[2]};
      sample.target = {target[0], target[1], target[2]};
      sample.fov_y_deg = shot.value("fov_y_deg", 60.0);
      sample.name = shot.at("name").get<std::string>();
      std::string cause = fault_of(sample);
      if (!names_a_file(sample.name)) cause = "its name is not 1 to 64 of the characters A-Z a-z 0-9 _ -";
      if (std::ranges::any_of(path, [&](const CameraSample& other) { return other.name == sample.name; }))
        cause = "its name comes twice";
      if (!cause.empty())
        return Error{ErrorCode::kFormat, "shot " + std::to_string(path.size() + 1) + ": " + cause, file};
      path.push_back(std::move(sample));
    }
  } catch (const nlohmann::json::exception& fault) {
    std::string cause = fault.what();  // "[json.exception…] cause"
    if (const std::size_t end = cause.find("] "); end != std::string::npos) cause.erase(0, end + 2);
    return Error{ErrorCode::kFormat, "not a shots file: " + cause, file};
  }
  return path;
}

}  // namespace

Result<CameraPath> read_camera_path(const std::filesystem::path& file) {
  ZC_ASSIGN(const std::vector<std::byte> bytes, read_file(file, kLargestPath));
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  const std::size_t first = text.find_first_not_of(" \t\r\n");
  const bool json = first != std::string_view::npos && text[first] == '{';
  ZC_ASSIGN(CameraPath path, json ? read_shots(text, file.string()) : read_csv(text, file.string()));
  if (path.empty()) return Error{ErrorCode::kFormat, "contains no camera", file.string()};
  return path;
}

CameraSample camera_at(const CameraPath& path, double time_s) {
  const auto after =
      std::ranges::upper_bound(path, time_s, {}, [](const CameraSample& sample) { return sample.time_s; });
  if (after == path.begin()) return path.front();
  const CameraSample& a = *(after - 1);
  if (after == path.end() || !a.name.empty()) return a;
  const double share = (time_s - a.time_s) / (after->time_s - a.time_s);  // upper_bound: not the same time
  CameraSample between{time_s, glm::mix(a.eye, after->eye, share), glm::mix(a.target, after->target, share),
                       glm::mix(a.fov_y_deg, after->fov_y_deg, share)};
  // Halfway round a turn on the spot the target may pass through the eye.
  if (glm::length(between.target - between.eye) < 1e-6) between.target = between.eye + (a.target - a.eye);
  return between;
}

glm::dvec3 eye_at(const CameraPath& path, double time_s) { return camera_at(path, time_s).eye; }

std::string frame_name(const CameraSample& sample, std::uint64_t frame) {
  if (!sample.name.empty()) return sample.name;
  const std::string number = std::to_string(frame);
  return std::string(number.size() < 6 ? 6 - number.size() : 0, '0') + number;
}

}  // namespace zc
