/// \file Numbers in messages have four digits, or as many as tell them apart.

#include <limits>

#include <gtest/gtest.h>

#include "base/text.hpp"

namespace tanor {
using namespace detail;
namespace {

TEST(Text, OfNumbersHasFourDigits) {
  EXPECT_EQ(text(0.25000000000000117), "0.25");
  EXPECT_EQ(text(7.4325280275609636e-09), "7.433e-09");
  EXPECT_EQ(text(-1234.5678), "-1235");
  EXPECT_EQ(text(0.1), "0.1");
  EXPECT_EQ(text(std::numeric_limits<double>::quiet_NaN()), "nan");
  EXPECT_EQ(text(-std::numeric_limits<double>::infinity()), "-inf");
}

TEST(Text, OfWholeNumbersHasAllDigits) {
  EXPECT_EQ(text(12345.0), "12345");
  EXPECT_EQ(text(-7.0), "-7");
  EXPECT_EQ(text(1e6), "1e+06");
  EXPECT_EQ(text(1234567), "1234567");
}

TEST(Text, OfComparedNumbersTellsThemApart) {
  using Pair = std::array<std::string, 2>;
  EXPECT_EQ(texts_apart(std::array{1.0001, 1.0002}), (Pair{"1.0001", "1.0002"}));
  EXPECT_EQ(texts_apart(std::array{1.5, 2.123456}), (Pair{"1.5", "2.123"}));
  EXPECT_EQ(texts_apart(std::array{0.30000000000000004, 0.3}), (Pair{"0.30000000000000004", "0.3"}));
  EXPECT_EQ(texts_apart(std::array{0.123456, 0.123456}), (Pair{"0.1235", "0.1235"}));
}

}  // namespace
}  // namespace tanor
