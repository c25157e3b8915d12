// SPDX-License-Identifier: Apache-2.0
#include "base/file.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <string>

namespace zc {
namespace {

namespace fs = std::filesystem;

class WriteFile : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() / ("zonecast-file-test-" + std::to_string(::getpid()));
    fs::remove_all(folder_);
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  static Status write(const fs::path& path, const std::string& text) {
    return write_file(path, std::as_bytes(std::span(text)));
  }
  static std::string text(const fs::path& path) {
    const auto bytes = read_file(path, 1000);
    EXPECT_TRUE(bytes.ok());
    return {reinterpret_cast<const char*>(bytes->data()), bytes->size()};
  }

  fs::path folder_;
};

TEST_F(WriteFile, ReplacesWhatALinkLeadsTo) {
  ASSERT_TRUE(write(folder_ / "old", "old").ok());
  fs::create_symlink(folder_ / "old", folder_ / "link");
  fs::create_symlink(folder_ / "new", folder_ / "ahead");
  ASSERT_TRUE(write(folder_ / "link", "new").ok());
  ASSERT_TRUE(write(folder_ / "ahead", "made").ok());
  EXPECT_TRUE(fs::is_symlink(folder_ / "link") && fs::is_symlink(folder_ / "ahead"));
  EXPECT_EQ(text(folder_ / "old"), "new");
  EXPECT_EQ(text(folder_ / "new"), "made");
}

TEST_F(WriteFile, APipeStaysAPipe) {
  const fs::path pipe = folder_ / "pipe";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  const int reader = ::open(pipe.c_str(), O_RDONLY | O_NONBLOCK);
  ASSERT_GE(reader, 0);
  EXPECT_TRUE(write(pipe, "through").ok());
  std::string got(7, ' ');
  EXPECT_EQ(::read(reader, got.data(), got.size()), 7);
  EXPECT_EQ(got, "through");
  ::close(reader);
  EXPECT_TRUE(fs::is_fifo(pipe));
}

TEST_F(WriteFile, WhatCannotBeWrittenIsNamedAndLeavesNothing) {
  for (const fs::path& path : {folder_, folder_ / "none" / "file"}) {
    const Status written = write(path, "x");
    ASSERT_FALSE(written.ok());
    EXPECT_NE(written.error().describe().find(path.string()), std::string::npos);
  }
  EXPECT_TRUE(fs::is_empty(folder_));
}

}  // namespace
}  // namespace zc
