// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/bake_report.h"

#include <nlohmann/json.hpp>
#include <span>

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

std::string bake_json(const BakeReport& report) {
  Json json;
  json["bake_s"] = to_json(report.seconds);
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
