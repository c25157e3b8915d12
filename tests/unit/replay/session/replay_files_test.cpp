// SPDX-License-Identifier: Apache-2.0
#include "replay/session/replay_files.h"

#include <gtest/gtest.h>

#include <array>
#include <filesystem>
#include <fstream>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "replay/files/temporary_folder.h"

namespace zc {
namespace {

const Picture kPicture = {2, 2, std::vector<std::uint8_t>(16, 255)};

class ReplayFilesIn : public testing::Test {
 protected:
  void SetUp() override {
    ASSERT_TRUE(folder_.create().ok());
    options_.out = folder_.path();
  }
  // All files below the folder.
  [[nodiscard]] std::set<std::string> files() const {
    std::set<std::string> out;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(options_.out))
      if (entry.is_regular_file()) out.insert(entry.path().lexically_relative(options_.out).string());
    return out;
  }
  // A replay of so many frames.
  void replay(std::size_t cameras, std::uint64_t frames) {
    auto created = ReplayFiles::create(options_, cameras, frames);
    ASSERT_TRUE(created.ok()) << created.error().describe();
    ReplayFiles& files = **created;
    const FrameResult drawn;
    for (std::uint64_t frame = 0; frame < frames; ++frame) {
      for (std::size_t c = 0; options_.render && c < cameras; ++c) {
        ASSERT_TRUE(files.save_picture(kPicture, c, "f" + std::to_string(frame)).ok());
        for (const DebugView view : options_.debug_views)
          ASSERT_TRUE(files.save_debug_view(kPicture, c, view, "f" + std::to_string(frame)).ok());
      }
      ASSERT_TRUE(files.end_frame(frame, {}, options_.render ? &drawn : nullptr).ok());
    }
    ASSERT_TRUE(files.close("{}\n").ok());
  }

  TemporaryFolder folder_;
  ReplayOptions options_;
};

TEST_F(ReplayFilesIn, APictureHasAPlaceByCameraAndView) {
  options_.debug_views = {DebugView::kBvh};
  options_.contact_sheet = true;
  options_.trace = true;
  replay(2, 1);
  EXPECT_EQ(files(),
            (std::set<std::string>{"frames/f0.png", "bvh/f0.png", "camera_1/frames/f0.png", "camera_1/bvh/f0.png",
                                   "contact_sheet.png", "frames.csv", "stats.json", "trace.json"}));
}

TEST_F(ReplayFilesIn, EarlierPicturesGoAndNothingElseDoes) {
  options_.debug_views = {DebugView::kBvh, DebugView::kDepth};
  options_.contact_sheet = true;
  replay(3, 2);
  std::ofstream(options_.out / "frames" / "notes.txt") << "kept";
  std::ofstream(options_.out / "camera_1" / "mine.png") << "no picture of ours";
  options_.debug_views.clear();
  options_.contact_sheet = false;
  options_.render = false;
  replay(1, 1);
  EXPECT_EQ(files(), (std::set<std::string>{"frames/notes.txt", "camera_1/mine.png", "frames.csv", "stats.json"}));
  EXPECT_FALSE(std::filesystem::exists(options_.out / "camera_2"));
}

TEST_F(ReplayFilesIn, TheContactSheetHasTwelveFramesOfTheFirstCameraAtMost) {
  constexpr unsigned kGap = 4;  // round the pictures
  options_.contact_sheet = true;
  for (const auto& [frames, rows] : {std::pair{1U, 1U}, {5U, 2U}, {12U, 4U}, {100U, 4U}}) {
    replay(2, frames);
    std::ifstream sheet(options_.out / "contact_sheet.png", std::ios::binary);
    std::array<unsigned char, 24> head{};  // ends in width and height, big-endian
    ASSERT_TRUE(sheet.read(reinterpret_cast<char*>(head.data()), head.size()));
    const unsigned height = (static_cast<unsigned>(head[22]) << 8U | head[23]) - kGap;
    static const unsigned kOneRow = height;
    EXPECT_EQ(height / kOneRow, rows) << frames;
  }
}

}  // namespace
}  // namespace zc
