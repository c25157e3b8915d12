// SPDX-License-Identifier: GPL-3.0-or-later
// CityJSON 1.1 and 2.0 (one document) and CityJSONSeq (a header line, then one feature a line) into the scene: the
// highest level of detail of every city object; children at their parent's level join it.
// Units: metres of the document's CRS, its transform applied in double precision. Untrusted input.
#pragma once

#include <filesystem>
#include <istream>
#include <string>
#include <string_view>

#include "baker/import/shared/input_files.h"
#include "baker/import/shared/scene_builder.h"
#include "baker/import/shared/texture_images.h"
#include "base/result.h"

namespace zc {

// `text` is the whole file; images are read from `files`.
Status import_cityjson(std::string_view text, const std::string& path, const InputFiles& files, TextureImages& images,
                       SceneBuilder& builder);

// Reads line by line, holding one line at a time, of at most 256 MiB. `path` is for messages; images lie beside
// `model`.
Status import_cityjson_seq(std::istream& stream, const std::string& path, const std::filesystem::path& model,
                           const InputFiles& files, TextureImages& images, SceneBuilder& builder);

}  // namespace zc
