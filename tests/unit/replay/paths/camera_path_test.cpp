// SPDX-License-Identifier: Apache-2.0
#include "replay/paths/camera_path.h"

#include <gtest/gtest.h>
#include <stdlib.h>

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>

#include "base/file.h"

namespace zc {
namespace {

const std::string kHeader = "time_s,eye_x,eye_y,eye_z,target_x,target_y,target_z,fov_y_deg\n";

class CameraPathFile : public testing::Test {
 protected:
  void SetUp() override {
    std::string pattern = (std::filesystem::temp_directory_path() / "zonecast-path-XXXXXX").string();
    ASSERT_NE(mkdtemp(pattern.data()), nullptr);
    folder_ = pattern;
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  Result<CameraPath> read(const std::string& text) const {
    const std::filesystem::path file = folder_ / "path";
    EXPECT_TRUE(write_file(file, std::as_bytes(std::span(text))).ok());
    return read_camera_path(file);
  }
  // The cause, and the file it lies in.
  std::string fault(const std::string& text) const {
    const auto path = read(text);
    if (path.ok()) return "none";
    EXPECT_EQ(path.error().code, ErrorCode::kFormat);
    EXPECT_EQ(path.error().path, (folder_ / "path").string());
    return path.error().message;
  }

  std::filesystem::path folder_;
};

TEST_F(CameraPathFile, CsvKeepsEveryDigitOfLargeCoordinates) {
  const auto path = read(kHeader + "0.5,678072.561,5403450.171,414.297,678080.816,5403455.796,414.053,60\n");
  ASSERT_TRUE(path.ok()) << path.error().describe();
  ASSERT_EQ(path->size(), 1U);
  const CameraSample& sample = path->front();
  EXPECT_EQ(sample.time_s, 0.5);
  EXPECT_EQ(sample.eye, glm::dvec3(678072.561, 5403450.171, 414.297));
  EXPECT_EQ(sample.target, glm::dvec3(678080.816, 5403455.796, 414.053));
  EXPECT_EQ(sample.fov_y_deg, 60);
  EXPECT_TRUE(sample.name.empty());
}

TEST_F(CameraPathFile, CsvMayBeginWithAByteOrderMark) {
  const auto path = read("\xEF\xBB\xBF" + kHeader + "0,0,0,0,1,0,0,60\n");
  ASSERT_TRUE(path.ok()) << path.error().describe();
  EXPECT_EQ(path->size(), 1U);
}

TEST_F(CameraPathFile, CsvTakesEitherLineEndBlankLinesAndNoLastLineEnd) {
  std::string text = kHeader + "0,0,0,0,1,0,0,60\n\n1,0,0,0,1,0,0,60\n1,0,0,0,1,0,0,60";
  const auto unix_path = read(text);
  ASSERT_TRUE(unix_path.ok());
  EXPECT_EQ(unix_path->size(), 3U);
  for (std::size_t at = 0; (at = text.find('\n', at)) != std::string::npos; at += 2) text.replace(at, 1, "\r\n");
  const auto dos_path = read(text);
  ASSERT_TRUE(dos_path.ok()) << dos_path.error().describe();
  EXPECT_EQ(dos_path->size(), 3U);
}

TEST_F(CameraPathFile, CsvFaultsNameTheirLine) {
  const std::string good = "1,0,0,0,1,0,0,60\n";
  EXPECT_EQ(fault("time,x\n" + good), "line 1: expected the header " + kHeader.substr(0, kHeader.size() - 1));
  EXPECT_EQ(fault(kHeader + good + "2,nan,0,0,1,0,0,60\n"), "line 3: a value is not a finite number");
  EXPECT_EQ(fault(kHeader + good + "2,0,0,-inf,1,0,0,60\n"), "line 3: a value is not a finite number");
  EXPECT_EQ(fault(kHeader + "2,2e9,0,0,1,0,0,60\n"), "line 2: a value is beyond 1e9");
  EXPECT_EQ(fault(kHeader + "\n2,0,x,0,1,0,0,60\n"), "line 3: value 3 is not a number");
  EXPECT_EQ(fault(kHeader + "2,0,1e999,0,1,0,0,60\n"), "line 2: value 3 is not a number");
  EXPECT_EQ(fault(kHeader + "2,0,0,0,1,0,0\n"), "line 2: expected 8 values separated by commas");
  EXPECT_EQ(fault(kHeader + "2,0,0,0,1,0,0,60,1\n"), "line 2: expected 8 values separated by commas");
  EXPECT_EQ(fault(kHeader + "2,0,0,0,1,0,0,60 \n"), "line 2: expected 8 values separated by commas");
  EXPECT_EQ(fault(kHeader + good + "0.5,0,0,0,1,0,0,60\n"), "line 3: time runs backwards");
  EXPECT_EQ(fault(kHeader + "1,5,5,5,5,5,5,60\n"), "line 2: eye and target are the same point");
  EXPECT_EQ(fault(kHeader + "1,0,0,0,1,0,0,0.5\n"), "line 2: fov_y_deg is not between 1 and 170");
  EXPECT_EQ(fault(kHeader + "1,0,0,0,1,0,0,171\n"), "line 2: fov_y_deg is not between 1 and 170");
  EXPECT_EQ(fault(kHeader), "contains no camera");
  EXPECT_EQ(fault(""), "contains no camera");
}

TEST_F(CameraPathFile, EveryTruncatedPrefixIsAPathOrAnError) {
  const std::string text = kHeader + "0,10,20,30,11,20,30,60\n1,12,20,30,13,20,30,60\n";
  for (std::size_t length = 0; length <= text.size(); ++length) {
    const auto path = read(text.substr(0, length));
    if (path.ok()) {
      EXPECT_FALSE(path->empty()) << length;
    }
  }
}

TEST_F(CameraPathFile, ShotsAreNamedAndASecondApart) {
  const auto path = read(R"( {"shots": [
      {"name": "plaza", "eye": [1, 2, 3], "target": [4, 5, 6], "fov_y_deg": 45},
      {"name": "bridge", "eye": [7, 8, 9], "target": [0, 0, 0]}]})");
  ASSERT_TRUE(path.ok()) << path.error().describe();
  ASSERT_EQ(path->size(), 2U);
  EXPECT_EQ((*path)[0].name, "plaza");
  EXPECT_EQ((*path)[0].fov_y_deg, 45);
  EXPECT_EQ((*path)[1].eye, glm::dvec3(7, 8, 9));
  EXPECT_EQ((*path)[1].fov_y_deg, 60);
  EXPECT_EQ((*path)[1].time_s, 1);
}

TEST_F(CameraPathFile, ShotsFaultsNameTheirShot) {
  EXPECT_EQ(fault(R"({"shots": []})"), "contains no camera");
  const std::string view = R"("eye": [0, 0, 0], "target": [1, 1, 1]})";
  EXPECT_NE(fault(R"({"shots": [{"name": "a", )" + view + R"(, {"name": "a", )" + view + "]}").find("comes twice"),
            std::string::npos);
  for (const char* name : {"", "../a", "a b"}) {
    EXPECT_NE(fault(R"({"shots": [{"name": ")" + std::string(name) + R"(", )" + view + "]}").find("its name"),
              std::string::npos);
  }
  EXPECT_EQ(fault(R"({"shots": [{"name": "a", "eye": [0, 0, 0], "target": [0, 0, 0]}]})"),
            "shot 1: eye and target are the same point");
  for (const char* text : {"{", "{}", R"({"shots": 7})", R"({"shots": [7]})",
                           R"({"shots": [{"name": "a", "eye": [0, 0], "target": [1, 1, 1]}]})",
                           R"({"shots": [{"name": 1, "eye": [0, 0, 0], "target": [1, 1, 1]}]})",
                           R"({"shots": [{"name": "a", "eye": [0, null, 0], "target": [1, 1, 1]}]})"})
    EXPECT_EQ(fault(text).rfind("not a shots file: ", 0), 0U) << text << ": " << fault(text);
}

TEST_F(CameraPathFile, AMissingFileIsNamed) {
  const auto path = read_camera_path(folder_ / "none.csv");
  ASSERT_FALSE(path.ok());
  EXPECT_EQ(path.error().code, ErrorCode::kIo);
  EXPECT_EQ(path.error().path, (folder_ / "none.csv").string());
}

TEST(EyeAt, IsLinearBetweenSamplesAndHeldOutside) {
  CameraPath path(3);
  path[0] = {1, {0, 0, 0}, {1, 0, 0}};
  path[1] = {2, {10, 0, 0}, {11, 0, 0}};
  path[2] = {4, {10, 20, 0}, {11, 20, 0}};
  EXPECT_EQ(eye_at(path, 0), glm::dvec3(0, 0, 0));
  EXPECT_EQ(eye_at(path, 1), glm::dvec3(0, 0, 0));
  EXPECT_EQ(eye_at(path, 1.25), glm::dvec3(2.5, 0, 0));
  EXPECT_EQ(eye_at(path, 2), glm::dvec3(10, 0, 0));
  EXPECT_EQ(eye_at(path, 3), glm::dvec3(10, 10, 0));
  EXPECT_EQ(eye_at(path, 4), glm::dvec3(10, 20, 0));
  EXPECT_EQ(eye_at(path, 1e9), glm::dvec3(10, 20, 0));
}

TEST(CameraAt, MixesTargetAndFieldOfViewButNeverStillViews) {
  CameraPath path(2);
  path[0] = {1, {0, 0, 0}, {1, 0, 0}, 40};
  path[1] = {2, {10, 0, 0}, {11, 2, 0}, 60};
  const CameraSample half = camera_at(path, 1.5);
  EXPECT_EQ(half.eye, glm::dvec3(5, 0, 0));
  EXPECT_EQ(half.target, glm::dvec3(6, 1, 0));
  EXPECT_EQ(half.fov_y_deg, 50);
  EXPECT_EQ(half.time_s, 1.5);
  path[0].name = "still";
  EXPECT_EQ(camera_at(path, 1.9).eye, glm::dvec3(0, 0, 0));
  EXPECT_EQ(camera_at(path, 2).eye, glm::dvec3(10, 0, 0));
  CameraPath turn(2);
  turn[0] = {0, {0, 0, 0}, {1, 0, 0}};
  turn[1] = {1, {0, 0, 0}, {-1, 0, 0}};
  EXPECT_NE(camera_at(turn, 0.5).target, camera_at(turn, 0.5).eye);
}

TEST(EyeAt, JumpsBetweenSamplesOfOneTime) {
  CameraPath path(2);
  path[0] = {1, {0, 0, 0}, {1, 0, 0}};
  path[1] = {1, {5, 0, 0}, {6, 0, 0}};
  EXPECT_EQ(eye_at(path, 0.999), glm::dvec3(0, 0, 0));
  EXPECT_EQ(eye_at(path, 1), glm::dvec3(5, 0, 0));
}

}  // namespace
}  // namespace zc
