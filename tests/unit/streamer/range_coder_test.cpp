// SPDX-License-Identifier: Apache-2.0
#include "streamer/world_format/coding/range_coder.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <span>
#include <vector>

namespace zc {
namespace {

struct Models {
  Bit rare;
  Symbol<5> symbol;
  Number number;
  SignedNumber around_zero;
};

struct Values {
  std::uint32_t rare = 0, symbol = 0, number = 0, bits = 0;
  std::int32_t around_zero = 0;
  bool operator==(const Values&) const = default;
};

template <class Coder>
void code(Coder& coder, Models& models, Values& v) {
  coder.bit(models.rare, v.rare);
  models.symbol.code(coder, v.symbol);
  models.number.code(coder, v.number);
  coder.bits(v.bits, 17);
  models.around_zero.code(coder, v.around_zero);
}

std::vector<Values> some_values() {
  std::mt19937 engine(4);
  const auto random = [&] { return static_cast<std::uint32_t>(engine()); };
  std::vector<Values> values;
  for (int i = 0; i < 3000; ++i)
    values.push_back({random() % 50 == 0 ? 1U : 0U, random() % 32, random() >> random() % 32, random() & 0x1FFFF,
                      static_cast<std::int32_t>(random()) >> random() % 32});
  for (const std::uint32_t edge : {0U, 1U, 0x7FFFFFFFU, 0x80000000U, 0xFFFFFFFDU})
    values.push_back({1, 31, edge, 0x1FFFF, static_cast<std::int32_t>(edge)});
  for (Values& v : values) v.number = std::min(v.number, 0xFFFFFFFDU);
  for (Values& v : values) v.around_zero = std::clamp(v.around_zero, -0x7FFFFFFE, 0x7FFFFFFE);
  return values;
}

TEST(RangeCoder, GivesBackWhatItWasGivenAndEndsWhereItEnded) {
  std::vector<Values> values = some_values();
  Encoder encoder;
  Models written;
  for (Values& v : values) code(encoder, written, v);
  const std::vector<std::byte> bytes = encoder.finish();
  for (const std::size_t missing : {0U, 1U, 2U, 500U}) {
    Decoder decoder(std::span<const std::byte>(bytes).first(bytes.size() - missing));
    Models read;
    std::size_t same = 0;
    for (const Values& expected : values) {
      Values v;
      code(decoder, read, v);
      same += v == expected ? 1 : 0;
      EXPECT_LT(v.symbol, 32U);
    }
    EXPECT_EQ(decoder.at_end(), missing == 0);
    if (missing == 0) {
      EXPECT_EQ(same, values.size());
    }
  }
}

// A bit that is 1 once in fifty carries 0.141 bits.
TEST(RangeCoder, TakesAsMuchAsThereIsToSay) {
  std::mt19937 random(5);
  Encoder encoder;
  Bit model;
  constexpr std::size_t kBits = 100'000;
  for (std::size_t i = 0; i < kBits; ++i) {
    std::uint32_t bit = random() % 50 == 0 ? 1 : 0;
    encoder.bit(model, bit);
  }
  const double taken = 8.0 * static_cast<double>(encoder.finish().size()) / kBits;
  EXPECT_GT(taken, 0.135);
  EXPECT_LT(taken, 0.155);
}

}  // namespace
}  // namespace zc
