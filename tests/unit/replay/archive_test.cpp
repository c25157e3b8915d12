// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cstring>
#include <filesystem>
#include <map>
#include <memory>

#include "base/file.h"
#include "replay/files/archive_writer.h"
#include "streamer/open_source.h"
#include "streamer/source/archive_source.h"

namespace zc {
namespace {

using Bytes = std::vector<std::byte>;

class Archive : public testing::Test {
 protected:
  Archive() {
    std::filesystem::create_directories(folder_);
    for (int i = 0; i < 16; ++i) {
      Bytes bytes(static_cast<std::size_t>(i * 7 + 1));
      for (std::size_t k = 0; k < bytes.size(); ++k) bytes[k] = std::byte(i * 31 + static_cast<int>(k));
      files_["zones/" + std::to_string(i % 4) + "/" + std::to_string(i) + ".glb"] = std::move(bytes);
    }
  }
  ~Archive() override { std::filesystem::remove_all(folder_); }

  Bytes pack(const char* name = "a.3tz") {
    auto writer = ArchiveWriter::create(folder_ / name);
    EXPECT_TRUE(writer.ok());
    for (const auto& [file, bytes] : files_) EXPECT_TRUE(writer->add(file, bytes).ok());
    EXPECT_TRUE(writer->commit().ok());
    return *read_file(folder_ / name, 1 << 20);
  }

  const std::filesystem::path folder_ =
      std::filesystem::temp_directory_path() /
      (std::string("zonecast-archive-test-") + testing::UnitTest::GetInstance()->current_test_info()->name());
  std::map<std::string, Bytes> files_;
};

TEST_F(Archive, GivesBackWhatWasPutInAndNothingElse) {
  const Bytes first = pack();
  EXPECT_TRUE(pack("b.3tz") == first);
  auto source = open_source(folder_ / "a.3tz");
  ASSERT_TRUE(source.ok()) << source.error().describe();
  for (const auto& [name, bytes] : files_) {
    const auto read = (*source)->read(name, bytes.size());
    ASSERT_TRUE(read.ok()) << read.error().describe();
    EXPECT_TRUE(*read == bytes);
    EXPECT_TRUE(*(*source)->read_all(name, 1000) == bytes);
    EXPECT_FALSE((*source)->read(name, bytes.size() + 1).ok());
    EXPECT_FALSE((*source)->read_all(name, bytes.size() - 1).ok());
  }
  for (const char* name : {"", "zones", "zones/0/0.gl", "/zones/0/0.glb", "../a.3tz", "zones/0/0.glb2"}) {
    const auto read = (*source)->read_all(name, 1000);
    ASSERT_FALSE(read.ok());
    EXPECT_NE(read.error().describe().find("a.3tz"), std::string::npos);
  }
}

// The archive's own, a folder's, and those of a source that reads whole files only.
TEST_F(Archive, FilesAreReadPieceByPieceFromAnySource) {
  pack();
  class WholeFiles final : public Source {
   public:
    explicit WholeFiles(const std::map<std::string, Bytes>& files) : files_(files) {}
    Result<Bytes> read(const std::string& name, std::uint64_t bytes) override { return read_all(name, bytes); }
    Result<Bytes> read_all(const std::string& name, std::uint64_t limit) override {
      if (files_.count(name) == 0 || files_.at(name).size() > limit) return Error{ErrorCode::kIo, "no", name};
      return files_.at(name);
    }

   private:
    const std::map<std::string, Bytes>& files_;
  };
  std::vector<std::unique_ptr<Source>> sources;
  sources.push_back(*open_source(folder_ / "a.3tz"));
  sources.push_back(std::make_unique<WholeFiles>(files_));
  for (const auto& [name, bytes] : files_) {
    ASSERT_TRUE(make_folder((folder_ / "loose" / name).parent_path()).ok());
    ASSERT_TRUE(write_file(folder_ / "loose" / name, bytes).ok());
  }
  sources.push_back(*open_source(folder_ / "loose"));
  for (const auto& source : sources) {
    for (const auto& [name, bytes] : files_) {
      const auto file = source->open(name, bytes.size());
      ASSERT_TRUE(file.ok()) << file.error().describe();
      ASSERT_EQ((*file)->size_bytes(), bytes.size());
      Bytes read(bytes.size());
      for (std::size_t at = 0; at < read.size(); at += 7)
        ASSERT_TRUE((*file)->read(at, std::span(read).subspan(at, std::min<std::size_t>(7, read.size() - at))).ok());
      EXPECT_TRUE(read == bytes);
      Bytes more(2);
      EXPECT_FALSE((*file)->read(bytes.size() - 1, more).ok());
      EXPECT_FALSE((*file)->read(UINT64_MAX, more).ok());
      EXPECT_FALSE(source->open(name, bytes.size() - 1).ok());
    }
    EXPECT_FALSE(source->open("zones/none", 1000).ok());
    EXPECT_FALSE(source->open("../a.3tz", 1000).ok());
  }
}

TEST_F(Archive, AnOpenOneIsReadThroughAReplacement) {
  pack();
  auto source = open_source(folder_ / "a.3tz");
  ASSERT_TRUE(source.ok());
  const auto old = files_;
  for (auto& [name, bytes] : files_) bytes.assign(3, std::byte{9});
  pack();
  for (const auto& [name, bytes] : old) EXPECT_TRUE(*(*source)->read(name, bytes.size()) == bytes);
}

// Every byte changed, every length cut: an error, or the bytes that are there, never anything outside.
TEST_F(Archive, DamagedOnesAreErrorsOrGiveWhatIsThere) {
  const Bytes sound = pack();
  const auto file = folder_ / "bad.3tz";
  std::size_t refused = 0;
  std::size_t unread = 0;
  const auto appearance = [&](const Bytes& bytes) {
    ASSERT_TRUE(write_file(file, bytes).ok());
    auto source = open_source(file);
    if (!source.ok()) {
      ++refused;
      return;
    }
    for (const auto& [name, content] : files_) {
      const auto read = (*source)->read(name, content.size());
      unread += read.ok() ? 0 : 1;
      EXPECT_EQ(read.ok() ? read->size() : content.size(), content.size());
    }
  };
  for (std::size_t at = 0; at < sound.size(); ++at) {
    Bytes bytes = sound;
    bytes[at] ^= std::byte{static_cast<unsigned char>(at % 2 == 0 ? 0xFF : 0x04)};
    appearance(bytes);
  }
  for (std::size_t size = 0; size < sound.size(); size += 13)
    appearance({sound.begin(), sound.begin() + static_cast<long>(size)});
  EXPECT_GT(refused, sound.size() / 13 / 2);
  EXPECT_GT(unread, 200U);
}

TEST_F(Archive, OtherFilesAreNamed) {
  EXPECT_FALSE(open_source(folder_ / "none").ok());
  EXPECT_NE(open_source(folder_ / "none").error().describe().find("none"), std::string::npos);
  ASSERT_TRUE(write_file(folder_ / "text", Bytes(5000, std::byte{'x'})).ok());
  EXPECT_FALSE(open_source(folder_ / "text").ok());
  EXPECT_FALSE(open_source("/dev/null").ok());
  EXPECT_TRUE(open_source(folder_).ok());
}

TEST_F(Archive, AWriterThatIsGivenUpLeavesNothing) {
  const Bytes sound = pack();
  {
    auto writer = ArchiveWriter::create(folder_ / "a.3tz");
    ASSERT_TRUE(writer.ok());
    ASSERT_TRUE(writer->add("x", Bytes(10)).ok());
  }
  EXPECT_TRUE(*read_file(folder_ / "a.3tz", 1 << 20) == sound);
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder_), {}), 1);
  std::filesystem::create_directory(folder_ / "d.3tz");
  EXPECT_FALSE(ArchiveWriter::create(folder_ / "d.3tz").ok());
  EXPECT_FALSE(ArchiveWriter::create(folder_ / "none" / "a.3tz").ok());
}

}  // namespace
}  // namespace zc
