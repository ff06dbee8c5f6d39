#include "base/checksum.hpp"

#include <gtest/gtest.h>

namespace tanor {
using namespace detail;
namespace {

std::uint64_t sum_of(std::string_view text) {
  Checksum sum;
  sum.add(text);
  return sum.value();
}

// There are 19 bytes, which are two whole words and three bytes more.
constexpr std::string_view words = "nineteen bytes long";
static_assert(words.size() == 19);

TEST(ChecksumTest, DoesNotDependOnHowBytesAreCutIntoPieces) {
  for (std::size_t first = 0; first <= words.size(); ++first) {
    for (std::size_t second = first; second <= words.size(); ++second) {
      Checksum sum;
      sum.add(words.substr(0, first));
      sum.add(words.substr(first, second - first));
      sum.add(words.substr(second));
      EXPECT_EQ(sum.value(), sum_of(words)) << first << ", " << second;
    }
  }
}

TEST(ChecksumTest, EveryBitMatters) {
  for (std::size_t bit = 0; bit < 8 * words.size(); ++bit) {
    std::string other(words);
    other[bit / 8] = static_cast<char>(other[bit / 8] ^ (1 << (bit % 8)));
    EXPECT_NE(sum_of(other), sum_of(words)) << bit;
  }
}

TEST(ChecksumTest, BytesThatAreZeroCount) {
  std::string zeros;
  std::uint64_t before = sum_of(zeros);
  for (int count = 1; count <= 17; ++count) {
    zeros.push_back('\0');
    EXPECT_NE(sum_of(zeros), before) << count;
    before = sum_of(zeros);
  }
}

}  // namespace
}  // namespace tanor
