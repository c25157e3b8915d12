// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/write/world_writer.h"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <functional>

#include "base/file.h"
#include "streamer/world_format/world_index.h"

namespace zc {
namespace {

namespace fs = std::filesystem;

// Worlds whose index is a word.
class Writer : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() / ("zonecast-writer-test-" + std::to_string(::getpid()));
    fs::remove_all(folder_);
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  [[nodiscard]] fs::path world() const { return folder_ / "world"; }
  [[nodiscard]] fs::path beside() const { return folder_ / ".world.baking"; }

  Status put(WorldWriter& writer, const std::string& word) {
    ZC_TRY(writer.make_directory("zones/0"));
    ZC_TRY(writer.write_text("zones/0/0_0.glb", word));
    return writer.write_text(kWorldIndexName, word);
  }
  Status bake(const std::string& word, bool may_exchange = true) {
    ZC_ASSIGN(WorldWriter writer, WorldWriter::open(world()));
    ZC_TRY(put(writer, word));
    return writer.commit(may_exchange);
  }
  // Of the world; empty when there is none or it is not whole.
  [[nodiscard]] std::string word() const {
    const auto index = read_file(world() / kWorldIndexName, 100);
    const auto zone = read_file(world() / "zones/0/0_0.glb", 100);
    if (!index.ok() || !zone.ok() || *index != *zone) return {};
    return {reinterpret_cast<const char*>(index->data()), index->size()};
  }
  // A process that does this and is killed.
  static void killed(const std::function<void()>& work) {
    const pid_t child = ::fork();
    if (child == 0) {
      work();
      ::kill(::getpid(), SIGKILL);
    }
    int status = 0;
    ASSERT_EQ(::waitpid(child, &status, 0), child);
    ASSERT_TRUE(WIFSIGNALED(status) && WTERMSIG(status) == SIGKILL);
  }

  fs::path folder_;
};

TEST_F(Writer, AWorldReplacesAnotherWithOrWithoutAnExchangeOfNamesAndLeavesNothingBeside) {
  for (const bool may_exchange : {true, false}) {
    ASSERT_TRUE(bake("old").ok());
    EXPECT_EQ(word(), "old");
    ASSERT_TRUE(bake("new", may_exchange).ok());
    EXPECT_EQ(word(), "new");
    EXPECT_FALSE(fs::exists(beside()));
    fs::remove_all(world());
  }
}

TEST_F(Writer, AWriterThatIsDroppedLeavesTheOldWorldAndNothingBeside) {
  ASSERT_TRUE(bake("old").ok());
  {
    auto writer = WorldWriter::open(world());
    ASSERT_TRUE(writer.ok());
    ASSERT_TRUE(put(*writer, "new").ok());
    EXPECT_EQ(word(), "old");
  }
  EXPECT_EQ(word(), "old");
  EXPECT_FALSE(fs::exists(beside()));
}

TEST_F(Writer, WhatAKilledBakeLeavesIsRemovedByTheNext) {
  ASSERT_TRUE(bake("old").ok());
  const std::function<void()> stages[] = {
      [&] {
        const auto writer = WorldWriter::open(world());
        ::kill(::getpid(), SIGKILL);
      },
      [&] {
        auto writer = WorldWriter::open(world());
        (void)writer->write_text("tileset.json", "half");
        ::kill(::getpid(), SIGKILL);
      },
      [&] {
        auto writer = WorldWriter::open(world());
        (void)put(*writer, "killed");
        ::kill(::getpid(), SIGKILL);
      },
  };
  for (const auto& stage : stages) {
    killed(stage);
    EXPECT_EQ(word(), "old");
    EXPECT_TRUE(fs::exists(beside() / "world"));
    ASSERT_TRUE(bake("old").ok());
    EXPECT_FALSE(fs::exists(beside()));
    EXPECT_TRUE(fs::exists(world() / kWorldIndexName));
    EXPECT_FALSE(fs::exists(world() / "tileset.json"));
  }
}

// Between the two renames of a file system that cannot exchange names.
TEST_F(Writer, AnOldWorldThatWasOnItsWayOutComesBack) {
  ASSERT_TRUE(bake("old").ok());
  killed([&] {
    auto writer = WorldWriter::open(world());
    (void)put(*writer, "killed");
    fs::rename(world(), beside() / "old");
    ::kill(::getpid(), SIGKILL);
  });
  EXPECT_EQ(word(), "");
  { EXPECT_TRUE(WorldWriter::open(world()).ok()); }
  EXPECT_EQ(word(), "old");
  EXPECT_FALSE(fs::exists(beside()));
}

TEST_F(Writer, ASecondBakeIsRefusedWhileTheFirstLivesAndTakesNothingFromIt) {
  ASSERT_TRUE(bake("old").ok());
  auto first = WorldWriter::open(world());
  ASSERT_TRUE(first.ok());
  ASSERT_TRUE(put(*first, "first").ok());
  const auto second = WorldWriter::open(world());
  ASSERT_FALSE(second.ok());
  EXPECT_EQ(second.error().code, ErrorCode::kIo);
  EXPECT_EQ(second.error().describe(), world().string() + ": another bake is writing this world");
  ASSERT_TRUE(first->commit().ok());
  EXPECT_EQ(word(), "first");
}

TEST_F(Writer, NothingOfTheUsersGoes) {
  fs::create_directories(world());
  ASSERT_TRUE(write_file(world() / "notes.txt", {}).ok());
  const auto writer = WorldWriter::open(world());
  ASSERT_FALSE(writer.ok());
  EXPECT_EQ(writer.error().code, ErrorCode::kArgument);
  EXPECT_FALSE(fs::exists(beside()));
  fs::remove_all(world());
  fs::create_directories(beside());
  ASSERT_TRUE(write_file(beside() / "notes.txt", {}).ok());
  ASSERT_TRUE(bake("new").ok());
  EXPECT_TRUE(fs::exists(beside() / "notes.txt"));
}

}  // namespace
}  // namespace zc
