// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/bake_report.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <span>

#include "baker/bake.h"

namespace zc {
namespace {

using Json = nlohmann::ordered_json;

Json to_json(const BakeSeconds& s) {
  return {
      {"total", s.total},       {"import", s.import_s}, {"repair", s.repair}, {"exterior", s.exterior}, {"cut", s.cut},
      {"simplify", s.simplify}, {"light", s.light},     {"encode", s.encode}, {"atlas", s.atlas},       {"bvh", s.bvh}};
}

Json to_json(const DiskParts& parts) {
  return {{"triangles", parts.triangles},
          {"mesh", parts.mesh},
          {"json", parts.json},
          {"tree", parts.bvh.tree},
          {"materials", parts.bvh.materials},
          {"looks", parts.bvh.appearances},
          {"light", parts.bvh.light},
          {"normals", parts.bvh.normals},
          {"texture", parts.bvh.texture}};
}

Json to_json(std::span<const ImportCount> notes) {
  Json list = Json::array();
  for (const ImportCount& note : notes) {
    list.push_back({{"what", note.what}, {"count", note.count}});
    if (!note.names.empty()) list.back()["names"] = note.names;
  }
  return list;
}

// `notes`: of the import; what it missed was left out too.
Json to_json(std::span<const LeftOut> left_out, std::span<const ImportCount> notes) {
  Json list = Json::array();
  for (const ImportCount& note : notes)
    if (note.is_missing)
      list.push_back({{"what", note.what}, {"count", note.count}, {"page_bytes", 0}, {"names", note.names}});
  for (const LeftOut& left : left_out) {
    list.push_back({{"what", left.what}, {"count", left.count}, {"page_bytes", left.page_bytes}});
    if (left.disk_bytes > 0) list.back()["disk_bytes"] = left.disk_bytes;
  }
  return list;
}

Json to_json(const InputIdentity& input) {
  Json json = {{"path", input.path}, {"bytes", nullptr}, {"xxh3", nullptr}};
  if (input.bytes) {
    json["bytes"] = *input.bytes;
    json["xxh3"] = input.xxh3;
  }
  return json;
}

Json to_json(const BakeOptions& options) {
  const auto methods = bvh_methods();
  const auto method = std::ranges::find(methods, options.bvh.method, &BvhMethodName::method);
  const BakeOrigin& origin = options.origin;
  Json json = {{"error_m", options.error_m},
               {"leaf_triangles", options.leaf_triangles},
               {"bvh", method == methods.end() ? "" : method->name},
               {"atlas", options.atlas_size},
               {"light", options.light},
               {"sun", nullptr},
               {"exterior", options.exterior},
               {"step_log2", options.step_log2},
               {"reuse", options.reuse},
               {"threads", options.threads},
               {"skip_missing", origin.skip_missing},
               {"strict", origin.strict},
               {"materials", nullptr},
               {"wet", origin.wet},
               {"ground_plane", nullptr},
               {"scale", origin.scale},
               {"up", origin.up},
               {"offset", origin.offset},
               {"crs", origin.crs}};
  if (options.sun) json["sun"] = {options.sun->azimuth_deg, options.sun->elevation_deg};
  if (origin.materials) json["materials"] = to_json(*origin.materials);
  if (!origin.ground_plane.empty()) json["ground_plane"] = origin.ground_plane;
  return json;
}

}  // namespace

BakeSeconds BakeSeconds::of(const BakeContext& context, double import_s) {
  const auto of = [&](BakeStage stage) { return context.seconds(stage); };
  BakeSeconds out;
  out.import_s = import_s;
  out.repair = of(BakeStage::kSnap) + of(BakeStage::kRepair);
  out.exterior = of(BakeStage::kExterior);
  out.cut = of(BakeStage::kCut);
  out.simplify = of(BakeStage::kSimplify);
  out.light = of(BakeStage::kLight);
  out.encode = of(BakeStage::kEncode);
  out.atlas = of(BakeStage::kAtlas);
  out.bvh = of(BakeStage::kBvh);
  out.total = out.import_s + out.repair + out.exterior + out.cut + out.simplify + out.light + out.encode + out.atlas +
              out.bvh + of(BakeStage::kIndex);
  return out;
}

std::string bake_json(const BakeReport& report, const BakeOptions& options) {
  Json json;
  json["bake_s"] = to_json(report.seconds);
  json["version"] = nullptr;
  if (!options.origin.version.empty()) json["version"] = options.origin.version;
  json["format"] = kWorldVersion;
  json["inputs"] = Json::array();
  for (const InputIdentity& input : options.origin.inputs) json["inputs"].push_back(to_json(input));
  json["options"] = to_json(options);
  json["peak_rss_bytes"] = report.peak_rss_bytes;
  json["source_triangles"] = report.index.header.source_triangles;
  json["nodes"] = report.index.nodes.size();
  json["proxies"] = {
      {"reused", report.proxies_reused}, {"built", report.proxies_built}, {"work", report.simplify_work}};
  json["lights"] = {{"reused", report.lights_reused}, {"built", report.lights_built}};
  json["disk_bytes"] = {{"proxies", to_json(report.proxies)}, {"detail", to_json(report.detail)}};
  json["repair"] = {{"counts", to_json(report.repair.counts)},
                    {"open_edges", report.repair.open_edges},
                    {"border_error_m", report.repair.border_error_m}};
  json["left_out"] = to_json(report.left_out, report.notes);
  json["reflecting"] = {{"roughness_below", 0.35}, {"share_of_surface", report.reflecting_share}};
  json["notes"] = to_json(report.notes);
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace zc
