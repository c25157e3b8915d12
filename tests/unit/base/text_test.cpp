// SPDX-License-Identifier: Apache-2.0
#include "base/text.h"

#include <gtest/gtest.h>

namespace zc {
namespace {

TEST(Printable, WhatATerminalWouldObeyIsSpeltOut) {
  EXPECT_EQ(printable("wall.png"), "wall.png");
  EXPECT_EQ(printable("a\nb\r\tc"), "a\\nb\\r\\tc");
  EXPECT_EQ(printable("\x1b[31mred\x7f"), "\\x1b[31mred\\x7f");
  EXPECT_EQ(printable(std::string_view("a\0b", 3)), "a\\x00b");
  EXPECT_EQ(printable("Stra\xc3\x9f"
                      "e \xe6\x9d\xb1 \xf0\x9f\x8f\xa0"),
            "Stra\xc3\x9f"
            "e \xe6\x9d\xb1 \xf0\x9f\x8f\xa0");
  EXPECT_EQ(printable("\xc2\x9b"
                      "31m"),
            "\\xc2\\x9b31m");  // the control sequence introducer in one character
  EXPECT_EQ(printable("\xe2\x80\xae"
                      "gnp"),
            "\\xe2\\x80\\xaegnp");  // right to left
  EXPECT_EQ(printable("\xc0\xaf\xed\xa0\x80\xf5\xe6\x9d"), "\\xc0\\xaf\\xed\\xa0\\x80\\xf5\\xe6\\x9d");
  EXPECT_EQ(printable(printable("a\nb")), printable("a\nb"));
}

TEST(Printable, LongTextKeepsBothEndsAndWholeCharacters) {
  const std::string name = std::string(5000, 'a') + ".png";
  const std::string shown = printable(name, 100);
  EXPECT_LE(shown.size(), 105U);
  EXPECT_TRUE(shown.starts_with("aaaa"));
  EXPECT_TRUE(shown.ends_with("a.png"));
  for (std::size_t most = 8; most < 40; ++most) {
    std::string text;
    for (int i = 0; i < 30; ++i) text += i % 3 == 0 ? "\n" : "\xe6\x9d\xb1";
    const std::string cut = printable(text, most);
    EXPECT_EQ(printable(cut), cut) << "a character was cut in two";
    EXPECT_EQ(cut.find("\n"), std::string::npos);
    EXPECT_LE(cut.size(), most + 5) << most;
  }
}

}  // namespace
}  // namespace zc
