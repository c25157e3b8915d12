// SPDX-License-Identifier: GPL-3.0-or-later
#include "baker/import/stray_objects.h"

#include <gtest/gtest.h>

#include "tests/unit/baker/test_city.h"

namespace zc {
namespace {

using test::SceneMaker;

using Lines = std::vector<std::string>;

void house(SceneMaker& maker, double x, double y, const std::string& id) {
  maker.box({x, y, 0}, {x + 10, y + 10, 8});
  maker.object(ObjectKind::kObject);
  maker.scene.objects.back().id = id;
}

TEST(StrayObjects, AreNamedWithTheirDistance) {
  SceneMaker maker;
  house(maker, 0, 0, "zurich");
  house(maker, 1'900'010, 0, "vienna");
  EXPECT_EQ(describe_stray_objects(maker.scene), Lines{"1 object lies 1,900 km from the others: 'vienna'"});
  for (int i = 0; i < 5; ++i) house(maker, 50 * i, 30, "more");
  for (int i = 0; i < 4; ++i) house(maker, 1'950'000 + 20 * i, 40, "linz");
  EXPECT_EQ(describe_stray_objects(maker.scene),
            Lines{"5 objects lie 1,900 km from the others: 'vienna', 'linz', 'linz', ..."});
}

TEST(StrayObjects, OneFarVertexMakesItsObjectReachThere) {
  SceneMaker maker;
  for (int i = 0; i < 9; ++i) house(maker, 50 * i, 30, "house");
  maker.triangle({0, 0, 0}, {20, 0, 0}, {142, 1e6, 0}, 0);
  maker.object(ObjectKind::kObject);
  maker.scene.objects.back().id = "roof\n";
  const Lines lines = describe_stray_objects(maker.scene);
  ASSERT_EQ(lines.size(), 1U);
  EXPECT_EQ(lines[0].find("1 object reaches 1,000 km from the others: 'roof"), 0U) << lines[0];
  EXPECT_EQ(lines[0].find('\n'), std::string::npos);
}

TEST(StrayObjects, CitiesAndCountriesHaveNone) {
  EXPECT_EQ(describe_stray_objects(test::small_city()), Lines{});
  SceneMaker country;
  for (int i = 0; i < 400; ++i) house(country, i % 20 * 40'000.0, i / 20 * 40'000.0, "town");
  EXPECT_EQ(describe_stray_objects(country.scene), Lines{});
  SceneMaker one;
  one.quad({0, 0, 0}, {1e6, 0, 0}, {1e6, 1e6, 0}, {0, 1e6, 0}, 2);
  one.object(ObjectKind::kGround);
  EXPECT_EQ(describe_stray_objects(one.scene), Lines{});
  EXPECT_EQ(describe_stray_objects(Scene{}), Lines{});
}

}  // namespace
}  // namespace zc
