// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/import/identify_input.h"

#include <xxhash.h>

#include <array>
#include <cstdio>
#include <fstream>
#include <memory>
#include <vector>

#include "baker/import/input_folder.h"
#include "streamer/source/source.h"

namespace zc {
namespace {

constexpr std::size_t kChunkBytes = 1U << 20U;

class Hash {
 public:
  Hash() { XXH3_64bits_reset(state_.get()); }

  void add(const void* bytes, std::size_t count) { XXH3_64bits_update(state_.get(), bytes, count); }
  [[nodiscard]] std::string digits() const {
    std::array<char, 17> text{};
    std::snprintf(text.data(), text.size(), "%016llx",
                  static_cast<unsigned long long>(XXH3_64bits_digest(state_.get())));
    return text.data();
  }

 private:
  struct Free {
    void operator()(XXH3_state_t* state) const { XXH3_freeState(state); }
  };
  std::unique_ptr<XXH3_state_t, Free> state_{XXH3_createState()};
};

// The bytes of the file.
Result<std::uint64_t> add_file(const std::filesystem::path& file, Hash& hash) {
  std::ifstream stream(file, std::ios::binary);
  std::vector<char> chunk(kChunkBytes);
  std::uint64_t bytes = 0;
  while (stream) {
    stream.read(chunk.data(), static_cast<std::streamsize>(chunk.size()));
    const auto count = static_cast<std::size_t>(stream.gcount());
    hash.add(chunk.data(), count);
    bytes += count;
  }
  if (!stream.eof()) return Error{ErrorCode::kIo, "cannot be read to its end", file.string()};
  return bytes;
}

}  // namespace

Result<InputIdentity> identify_input(const std::filesystem::path& input) {
  InputIdentity identity{input.string(), std::nullopt, {}};
  std::error_code code;
  Hash hash;
  if (is_url(input.native())) return identity;
  if (std::filesystem::is_regular_file(input, code)) {
    ZC_ASSIGN(identity.bytes, add_file(input, hash));
    identity.xxh3 = hash.digits();
  } else if (std::filesystem::is_directory(input, code)) {
    ZC_ASSIGN(const std::vector<std::filesystem::path> models, models_in_folder(input));
    identity.bytes = 0;
    for (const std::filesystem::path& model : models) {
      Hash content;
      ZC_ASSIGN(const std::uint64_t bytes, add_file(model, content));
      const std::string line = model.lexically_relative(input).generic_string() + '\0' + content.digits();
      hash.add(line.data(), line.size());
      *identity.bytes += bytes;
    }
    identity.xxh3 = hash.digits();
  }
  return identity;
}

}  // namespace zc
