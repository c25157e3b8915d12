// SPDX-License-Identifier: Apache-2.0
#include "replay/session/variant_cache.h"

#include <gtest/gtest.h>
#include <stdlib.h>

#include <span>

#include "base/file.h"
#include "replay/files/temporary_folder.h"

namespace zc {
namespace {

const VariantKey kHere{"a device", "a driver 1.2"};
constexpr TraceVariant kSlow{0, gpu::kPoolStorage, true, 32};

class VariantCache : public testing::Test {
 protected:
  void SetUp() override {
    ASSERT_TRUE(folder_.create().ok());
    file_ = folder_.path() / "below" / "variants.json";
  }
  void put(const std::string& text) {
    std::filesystem::create_directories(file_.parent_path());
    ASSERT_TRUE(write_file(file_, std::as_bytes(std::span(text))).ok());
  }
  std::string text() {
    const auto bytes = read_file(file_, 1U << 20U);
    return bytes ? std::string(reinterpret_cast<const char*>(bytes->data()), bytes->size()) : "";
  }

  TemporaryFolder folder_;
  std::filesystem::path file_;
};

TEST_F(VariantCache, KeepsAnEntryADevice) {
  EXPECT_FALSE(read_cached_variant(file_, kHere).has_value());
  ASSERT_TRUE(write_cached_variant(file_, kHere, kSlow).ok());
  ASSERT_TRUE(write_cached_variant(file_, {"another", "driver"}, {}).ok());
  EXPECT_EQ(read_cached_variant(file_, kHere), kSlow);
  EXPECT_EQ(read_cached_variant(file_, {"another", "driver"}), TraceVariant{});
  ASSERT_TRUE(write_cached_variant(file_, kHere, {}).ok());
  EXPECT_EQ(read_cached_variant(file_, kHere), TraceVariant{});
}

TEST_F(VariantCache, ANewDriverTakesTheOldOnesPlace) {
  ASSERT_TRUE(write_cached_variant(file_, kHere, kSlow).ok());
  EXPECT_FALSE(read_cached_variant(file_, {kHere.device, "a driver 1.3"}).has_value());
  ASSERT_TRUE(write_cached_variant(file_, {kHere.device, "a driver 1.3"}, {}).ok());
  EXPECT_FALSE(read_cached_variant(file_, kHere).has_value());
}

TEST_F(VariantCache, EntriesOfOtherVersionsDoNotHold) {
  ASSERT_TRUE(write_cached_variant(file_, kHere, kSlow).ok());
  for (const auto& [ours, theirs] :
       {std::pair<std::string, std::string>{"\"" ZONECAST_VERSION "\"", "\"0.0.1\""}, {"\"ZPG3\"", "\"ZPG1\""}}) {
    std::string old = text();
    const std::string now = old;
    ASSERT_NE(old.find(ours), std::string::npos) << old;
    put(old.replace(old.find(ours), ours.size(), theirs));
    EXPECT_FALSE(read_cached_variant(file_, kHere).has_value());
    put(now);
  }
  EXPECT_EQ(read_cached_variant(file_, kHere), kSlow);
}

TEST_F(VariantCache, WhatIsDamagedOrForeignIsAsGoodAsNoneAndWrittenAnew) {
  ASSERT_TRUE(write_cached_variant(file_, kHere, kSlow).ok());
  const std::string sound = text();
  for (std::size_t size = 0; size + 2 < sound.size(); ++size) {
    put(sound.substr(0, size));
    EXPECT_FALSE(read_cached_variant(file_, kHere).has_value()) << size;
  }
  const std::string unknown = std::string(sound).replace(sound.find("single"), 6, "double");
  for (const std::string& foreign :
       {std::string("[]"), std::string("7"), std::string(R"({"entries": {}})"), std::string(R"({"entries": [3, []]})"),
        R"({"entries": [)" + std::string(200'000, '[') + std::string(200'000, ']') + "]}",
        std::string("\xFF\xFE\x00", 3), std::string(2U << 20U, ' '), std::string(100'000, '['), unknown}) {
    put(foreign);
    EXPECT_FALSE(read_cached_variant(file_, kHere).has_value()) << foreign.substr(0, 40);
    ASSERT_TRUE(write_cached_variant(file_, kHere, kSlow).ok());
    EXPECT_EQ(read_cached_variant(file_, kHere), kSlow);
  }
}

TEST_F(VariantCache, StaysSmallHoweverManyDevicesComeAndGo) {
  for (int i = 0; i < 100; ++i) ASSERT_TRUE(write_cached_variant(file_, {"device " + std::to_string(i), "d"}, {}).ok());
  EXPECT_TRUE(read_cached_variant(file_, {"device 99", "d"}).has_value());
  EXPECT_FALSE(read_cached_variant(file_, {"device 0", "d"}).has_value());
}

TEST_F(VariantCache, APlaceThatCannotBeWrittenIsNamed) {
  const std::string text = "a file where the folder should be";
  ASSERT_TRUE(write_file(folder_.path() / "below", std::as_bytes(std::span(text))).ok());
  const Status kept = write_cached_variant(file_, kHere, kSlow);
  ASSERT_FALSE(kept.ok());
  EXPECT_NE(kept.error().describe().find((folder_.path() / "below").string()), std::string::npos);
  EXPECT_FALSE(read_cached_variant(file_, kHere).has_value());
}

TEST(VariantCacheFile, LiesWhereTheEnvironmentSays) {
  const auto set = [](const char* cache, const char* home) {
    cache != nullptr ? setenv("XDG_CACHE_HOME", cache, 1) : unsetenv("XDG_CACHE_HOME");
    home != nullptr ? setenv("HOME", home, 1) : unsetenv("HOME");
  };
  set("/c", "/h");
  EXPECT_EQ(variant_cache_file(), "/c/zonecast/trace_variants.json");
  set("relative", "/h");
  EXPECT_EQ(variant_cache_file(), "/h/.cache/zonecast/trace_variants.json");
  set("", "/h");
  EXPECT_EQ(variant_cache_file(), "/h/.cache/zonecast/trace_variants.json");
  set(nullptr, nullptr);
  EXPECT_EQ(variant_cache_file(), "");
}

}  // namespace
}  // namespace zc
