// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/import/import.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <memory>
#include <new>
#include <optional>
#include <string>
#include <string_view>

#include "baker/import/citygml/citygml_import.h"
#include "baker/import/cityjson/cityjson_import.h"
#include "baker/import/gltf/gltf_import.h"
#include "baker/import/input_folder.h"
#include "baker/import/input_formats.h"
#include "baker/import/obj/obj_import.h"
#include "baker/import/other_formats.h"
#include "baker/import/packed/gzip_file.h"
#include "baker/import/packed/zip_archive.h"
#include "baker/import/ply/ply_import.h"
#include "baker/import/shared/gunzip.h"
#include "baker/import/shared/input_files.h"
#include "baker/import/shared/scene_builder.h"
#include "baker/import/shared/texture_images.h"
#include "baker/import/shared/uri.h"
#include "baker/import/tiles/tile_content.h"
#include "baker/import/tiles/tileset_file.h"
#include "baker/import/tiles/tileset_import.h"
#include "base/file.h"
#include "base/text.h"
#include "streamer/source/source.h"

namespace zc {
namespace {

constexpr std::uint64_t kMaxInputBytes = std::uint64_t{1} << 34U;
constexpr std::size_t kHeadBytes = 64;

// A pipe or a device, which can be read but once. Names that lead nowhere are left to who opens them.
bool is_stream(const std::filesystem::path& input) {
  std::error_code failure;
  const std::filesystem::file_status status = std::filesystem::status(input, failure);
  return std::filesystem::is_fifo(status) || std::filesystem::is_character_file(status) ||
         std::filesystem::is_socket(status);
}

Result<std::ifstream> open_stream(const std::filesystem::path& file, const std::string& path) {
  std::ifstream stream(file, std::ios::binary);
  if (!stream) return Error{ErrorCode::kIo, std::string("cannot open: ") + std::strerror(errno), path};
  return stream;
}

// The first bytes, which tell formats apart.
Result<std::vector<std::byte>> head_of(const std::filesystem::path& file) {
  ZC_ASSIGN(const InputFile input, InputFile::open(file));
  std::vector<std::byte> head(std::min<std::uint64_t>(input.size_bytes(), kHeadBytes));
  ZC_TRY(input.read(0, head));
  return head;
}

Error no_models(const char* what, const std::filesystem::path& input) {
  return {ErrorCode::kUnsupported,
          std::string("is ") + what + " without city models, expected files of " + kReadFormats +
              "; name the folder or the files that are the city",
          input.string()};
}

Error refused(const OtherFormat& format, const std::filesystem::path& input) {
  return {ErrorCode::kUnsupported, std::string("is ") + format.what + ", expected " + kReadFormats + "; " + format.next,
          input.string()};
}

// A link that leads nowhere.
Status check_link(const std::filesystem::path& file) {
  std::error_code none;
  if (!std::filesystem::is_symlink(file, none) || std::filesystem::exists(file, none)) return {};
  return Error{ErrorCode::kIo,
               "is a link to '" + printable(std::filesystem::read_symlink(file, none).string(), 160) +
                   "', which is not there, expected a file; mend the link, or name the file itself",
               file.string()};
}

// What was found and left out is why nothing is there.
Error nothing_to_bake(const Scene& scene, const std::filesystem::path& input) {
  constexpr std::size_t kReasons = 5;  // of a message of one line
  std::string message = "has no triangles, expected city objects, meshes or tiles with surfaces";
  for (std::size_t i = 0; i < std::min(scene.notes.size(), kReasons); ++i)
    message += (i == 0 ? "; found: " : "; ") + scene.notes[i].what + ": " + std::to_string(scene.notes[i].count);
  return {ErrorCode::kFormat, message, input.string()};
}

// A model, and where it was found.
struct Source {
  std::filesystem::path path;
  const InputFiles& files;  // that what lies beside it is read from
  bool named = true;        // by the caller; or found in a folder or an archive, which may have other files too
};

class Importer {
 public:
  explicit Importer(const ImportOptions& options) : options_(options), builder_(options.materials) {}

  // What the caller named.
  Status add(const std::filesystem::path& input, const Placement& placement) {
    builder_.placement().enter_input(placement);
    if (is_url(input.native()))
      return account(input.string(), [&]() -> Status {
        ZC_TRY(enter_file(UpAxis::kZ, input.string()));
        return import_web_tiles(input.native(), options_.skip_missing, images_, builder_);
      });
    std::error_code failure;
    if (std::filesystem::is_directory(input, failure)) return add_folder(input);
    const bool is_standard_input = input == "-";
    if (!is_standard_input && !is_stream(input)) return add_file(input, true);
    const std::string path = is_standard_input ? "standard input" : input.string();
    return account(path, [&]() -> Status {
      ZC_ASSIGN(std::ifstream stream, open_stream(is_standard_input ? "/dev/stdin" : input, path));
      ZC_TRY(enter_file(UpAxis::kZ, path));
      return import_cityjson_seq(stream, path, {}, disk_files(), images_, builder_);
    });
  }

  Result<Scene> finish(const std::filesystem::path& first_input) {
    builder_.enter_file({});
    if (builder_.placement().crs_named() > 0)
      builder_.note_files("inputs without a reference system, taken to be in that of the others", without_crs_);
    builder_.note_files("files in folders and archives that are no city models, left out", other_files_);
    images_.report(builder_);
    if (options_.ground_plane) ZC_TRY(builder_.add_ground_plane(options_.ground_plane_z_m));
    Scene scene = builder_.finish(images_.take());
    if (scene.triangles.empty()) return nothing_to_bake(scene, first_input);
    return scene;
  }

 private:
  Status add_folder(const std::filesystem::path& folder) {
    ZC_ASSIGN(const std::vector<std::filesystem::path> models, models_in_folder(folder));
    for (const std::filesystem::path& model : models) ZC_TRY(add_file(model, false));
    return models.empty() ? Status(no_models("a folder", folder)) : Status();
  }

  Status add_archive(const std::filesystem::path& archive) {
    ZC_ASSIGN(const std::unique_ptr<ZipArchive> zip, ZipArchive::open(archive));
    for (const std::string& name : zip->names()) {
      if (name == "tileset.json")
        return account(archive.string(), [&]() -> Status {
          ZC_TRY(enter_file(UpAxis::kZ, archive.string()));
          return import_tiles_archive(archive, {zip.get(), options_.skip_missing}, images_, builder_);
        });
      if (std::filesystem::path(name).filename() == "tileset.json")
        return Error{ErrorCode::kUnsupported,
                     "is an archive of a 3D Tiles tileset, expected a tileset.json at its top; unpack it and bake its "
                     "tileset.json",
                     (archive / name).string()};
    }
    bool is_empty = true;
    for (const std::string& name : zip->names()) {
      if (!has_model_name(name)) continue;
      is_empty = false;
      const Source source{archive / name, *zip, false};
      ZC_TRY(account(source.path.string(), [&]() -> Status {
        ZC_ASSIGN(std::vector<std::byte> bytes, zip->read(source.path, kMaxInputBytes));
        return import_bytes(std::move(bytes), source);
      }));
    }
    if (!is_empty) return {};
    const std::optional<OtherFormat> other = other_archive(zip->names());
    return other ? refused(*other, archive) : no_models("an archive", archive);
  }

  Status add_file(const std::filesystem::path& file, bool named) {
    ZC_TRY(check_link(file));
    ZC_ASSIGN(const std::vector<std::byte> head, head_of(file));
    if (is_zip(head)) return add_archive(file);
    const Source source{file, disk_files(), named};
    return account(file.string(), [&]() -> Status {
      if (format_of(head) == InputFormat::kJson) {
        ZC_ASSIGN(std::ifstream stream, open_stream(file, file.string()));
        if (is_sequence(stream, file)) return import_sequence(stream, source);
      }
      ZC_ASSIGN(std::vector<std::byte> bytes, read_file(file, kMaxInputBytes));
      return import_bytes(std::move(bytes), source);
    });
  }

  // Line by line: a sequence on the disk is never whole in memory.
  Status import_sequence(std::istream& stream, const Source& source) {
    const auto rewind = [&] {
      stream.clear();
      stream.seekg(0);
    };
    rewind();
    if (!source.named && !begins_with_city_model(stream)) return leave_out(source);
    rewind();
    ZC_TRY(enter_file(UpAxis::kZ, source.path.string()));
    return import_cityjson_seq(stream, source.path.string(), source.path, source.files, images_, builder_);
  }

  Status import_bytes(std::vector<std::byte> bytes, const Source& source) {
    const std::string path = source.path.string();
    if (is_gzip(bytes)) {
      if (&source.files != &disk_files())
        return Error{ErrorCode::kUnsupported,
                     "is packed once more within its archive; unpack the archive and bake what is in it", path};
      ZC_ASSIGN(bytes, unpack_gzip(bytes, path));
    }
    const InputFormat format = format_of(bytes);
    const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    if (format == InputFormat::kJson)
      if (MemoryStream stream(bytes); is_sequence(stream, source.path)) return import_sequence(stream, source);
    if (!source.named && !is_city_model(format, text)) return leave_out(source);
    if (bytes.empty())
      return Error{ErrorCode::kFormat, std::string("is empty, expected ") + kReadFormats + "; get it again", path};
    const bool is_tiles = is_tile_content(text) || (format == InputFormat::kJson && is_tileset(text));
    const bool is_model = format == InputFormat::kGlb || (format == InputFormat::kJson && is_gltf(text));
    const bool is_without_rule = format == InputFormat::kObj || format == InputFormat::kPly;
    ZC_TRY(enter_file(is_model && !is_tiles ? UpAxis::kY : (is_without_rule ? kUpWithoutRule : UpAxis::kZ), path));
    const TilesetSource tiles{&source.files, options_.skip_missing};
    if (is_tiles) return import_tileset(std::move(bytes), source.path, tiles, images_, builder_);
    if (!is_city_model(format, text) || format == InputFormat::kXml)  // of which the root may not be legible
      if (const std::optional<OtherFormat> other = other_format(text)) return refused(*other, source.path);
    GltfPlace place;
    place.root = folder_of(source.path);
    place.files = &source.files;
    switch (format) {
      case InputFormat::kUnknown:
        break;
      case InputFormat::kXml:
        return import_citygml(std::move(bytes), path, source.files, images_, builder_);
      case InputFormat::kGlb:
        return import_gltf(std::move(bytes), path, place, images_, builder_);
      case InputFormat::kObj:
        return import_obj(bytes, path, source.files, images_, builder_);
      case InputFormat::kPly:
        return import_ply(bytes, path, source.files, images_, builder_);
      case InputFormat::kJson:
        if (is_gltf(text)) return import_gltf(std::move(bytes), path, place, images_, builder_);
        return import_cityjson(text, path, source.files, images_, builder_);
    }
    return Error{ErrorCode::kUnsupported,
                 std::string("is of no format that is read, expected ") + kReadFormats + "; convert it to one of them",
                 path, 0};
  }

  // Runs the import of one file: ends exceptions, and keeps account of reference systems.
  template <class Import>
  Status account(const std::string& path, const Import& import) {
    const std::uint64_t crs_named = builder_.placement().crs_named();
    const std::size_t left_out = other_files_.size();
    builder_.enter_file(path);
    try {
      if (Status status = import(); !status.ok()) {
        Error error = std::move(status).error();
        if (error.path.empty()) error.path = path;
        return error;
      }
    } catch (const std::bad_alloc&) {
      return Error{ErrorCode::kBudget, "not enough memory to import this file", path};
    }
    if (builder_.placement().crs_named() == crs_named && other_files_.size() == left_out) without_crs_.push_back(path);
    builder_.enter_file(path);  // and no object of it
    if (builder_.placement().is_of_degrees()) builder_.remark("files in degrees or geocentric, moved to a local frame");
    if (builder_.placement().converts()) builder_.remark("files in another reference system, moved to the world's");
    return {};
  }

  Status enter_file(UpAxis up, const std::string& path) { return builder_.placement().enter_file(up, path); }

  Status leave_out(const Source& source) {
    other_files_.push_back(source.path.string());
    return {};
  }

  const ImportOptions options_;
  TextureImages images_;
  SceneBuilder builder_;
  std::vector<std::string> without_crs_;
  std::vector<std::string> other_files_;
};

}  // namespace

Result<Scene> import_inputs(std::span<const std::filesystem::path> inputs, const ImportOptions& options) {
  if (inputs.empty()) return Error{ErrorCode::kArgument, "no input given"};
  Importer importer(options);
  const std::vector<Placement>& placements = options.placements;
  if (placements.size() > 1 && placements.size() != inputs.size())
    return Error{ErrorCode::kArgument, std::to_string(placements.size()) + " placements of " +
                                           std::to_string(inputs.size()) + " inputs, expected one for all or for each"};
  for (std::size_t i = 0; i < inputs.size(); ++i) {
    const Placement placement = placements.empty() ? Placement() : placements[placements.size() == 1 ? 0 : i];
    if (Status status = importer.add(inputs[i], placement); !status.ok()) {
      Error error = std::move(status).error();
      if (error.path.empty()) error.path = inputs[i].empty() ? "''" : inputs[i].string();
      return error;
    }
  }
  return importer.finish(inputs.front());
}

}  // namespace zc
