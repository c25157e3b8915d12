// SPDX-License-Identifier: Apache-2.0
#include "streamer/source/http/disk_cache.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <thread>

#include "base/file.h"

namespace zc {
namespace {

namespace fs = std::filesystem;

std::vector<std::byte> bytes_of(std::size_t count, int value) {
  return std::vector<std::byte>(count, std::byte(value));
}

class DiskCacheTest : public ::testing::Test {
 protected:
  void SetUp() override { fs::remove_all(folder_); }
  void TearDown() override { fs::remove_all(folder_); }

  std::unique_ptr<DiskCache> open(std::uint64_t limit_bytes) const {
    auto cache = DiskCache::open(folder_, limit_bytes);
    EXPECT_TRUE(cache.ok());
    return std::move(cache).value();
  }

  [[nodiscard]] std::vector<fs::path> entries() const {
    std::vector<fs::path> found;
    for (const auto& entry : fs::directory_iterator(folder_)) found.push_back(entry.path());
    return found;
  }

  [[nodiscard]] std::uint64_t held_bytes() const {
    std::uint64_t sum = 0;
    for (const fs::path& path : entries()) sum += fs::file_size(path);
    return sum;
  }

  const fs::path folder_ =
      fs::temp_directory_path() / ("zonecast-cache-test-" + std::to_string(::getpid())) / "made" / "here";
};

TEST_F(DiskCacheTest, gives_back_what_was_put_to_this_and_to_the_next_process) {
  const auto cache = open(1 << 20U);
  EXPECT_FALSE(cache->has("a"));
  EXPECT_FALSE(cache->get("a", 1000));
  cache->put("a", bytes_of(1000, 1));
  cache->put("b", {});
  for (int process = 0; process < 2; ++process) {
    const auto again = open(1 << 20U);
    EXPECT_TRUE(again->has("a"));
    EXPECT_EQ(again->get("a", 1000), bytes_of(1000, 1));
    EXPECT_EQ(again->get("b", 1000), std::vector<std::byte>());
    EXPECT_FALSE(again->get("a", 999)) << "larger than asked for";
    EXPECT_EQ(again->damaged(), 0U);
  }
  cache->put("a", bytes_of(10, 2));
  EXPECT_EQ(cache->get("a", 1000), bytes_of(10, 2));
  cache->remove("a");
  EXPECT_FALSE(cache->has("a"));
}

TEST_F(DiskCacheTest, every_damaged_entry_is_thrown_away) {
  const auto cache = open(1 << 20U);
  cache->put("key", bytes_of(100, 7));
  ASSERT_EQ(entries().size(), 1U);
  const fs::path path = entries().front();
  const auto whole = read_file(path, 1 << 20U);
  ASSERT_TRUE(whole.ok());
  std::uint64_t damaged = 0;
  for (std::size_t at = 0; at < whole->size(); ++at) {
    std::vector<std::byte> flipped = *whole;
    flipped[at] ^= std::byte{0x10};
    ASSERT_TRUE(write_file(path, flipped).ok());
    ASSERT_FALSE(cache->get("key", 1 << 20U)) << at;
    ASSERT_FALSE(fs::exists(path)) << at;
    ASSERT_EQ(cache->damaged(), ++damaged);
    ASSERT_TRUE(write_file(path, std::span(*whole).first(at)).ok());
    ASSERT_FALSE(cache->get("key", 1 << 20U)) << at;
    ASSERT_EQ(cache->damaged(), ++damaged);
  }
  ASSERT_TRUE(write_file(path, *whole).ok());
  EXPECT_EQ(cache->get("key", 1 << 20U), bytes_of(100, 7));
}

TEST_F(DiskCacheTest, holds_its_limit_and_lets_the_longest_unused_go) {
  constexpr std::uint64_t kLimit = 20'000;
  const auto cache = open(kLimit);
  const auto wait = [] { std::this_thread::sleep_for(std::chrono::milliseconds(5)); };  // times tell entries apart
  for (int i = 0; i < 100; ++i) {
    cache->put("entry " + std::to_string(i), bytes_of(1000, i));
    ASSERT_LE(held_bytes(), kLimit);
    ASSERT_TRUE(cache->get("entry 0", 1000)) << i;  // used again and again
    wait();
  }
  EXPECT_TRUE(cache->has("entry 99"));
  EXPECT_FALSE(cache->has("entry 1"));
  EXPECT_GT(held_bytes(), kLimit / 2);
  cache->put("too large", bytes_of(kLimit, 1));
  EXPECT_FALSE(cache->has("too large"));
  EXPECT_TRUE(cache->has("entry 99"));
  (void)open(5000);
  EXPECT_LE(held_bytes(), 5000U) << "a smaller limit counts at once";
}

TEST_F(DiskCacheTest, touches_nothing_else_in_its_folder) {
  fs::create_directories(folder_);
  for (const char* name : {"notes.txt", "00.zccache", "x.zccache"})
    ASSERT_TRUE(write_file(folder_ / name, bytes_of(50'000, 1)).ok());
  const auto cache = open(10'000);
  for (int i = 0; i < 20; ++i) cache->put(std::to_string(i), bytes_of(1000, i));
  for (const char* name : {"notes.txt", "00.zccache", "x.zccache"}) EXPECT_TRUE(fs::exists(folder_ / name)) << name;
  EXPECT_TRUE(cache->has("19"));
}

TEST_F(DiskCacheTest, threads_share_it) {
  const auto cache = open(50'000);
  std::vector<std::thread> threads;
  for (int t = 0; t < 4; ++t)
    threads.emplace_back([&, t] {
      for (int i = 0; i < 100; ++i) {
        const std::string key = std::to_string((i * 7 + t) % 60);
        const auto expected = bytes_of(1000, std::stoi(key));
        cache->put(key, expected);
        if (const auto got = cache->get(key, 1000)) {
          EXPECT_EQ(*got, expected);
        }
      }
    });
  for (std::thread& thread : threads) thread.join();
  EXPECT_LE(held_bytes(), 50'000U);
  EXPECT_EQ(cache->damaged(), 0U);
}

TEST_F(DiskCacheTest, a_place_that_cannot_be_a_folder_is_an_error) {
  EXPECT_FALSE(DiskCache::open("/dev/null/cache", 1000).ok());
}

}  // namespace
}  // namespace zc
