#include "report/npy.hpp"

#include <limits>

#include <gtest/gtest.h>

#include "report/reading.hpp"

namespace tanor::report {
namespace {

using Shape = std::vector<std::size_t>;

TEST(NpyTest, ArraysReadBackBitByBit) {
  const Folder folder;
  const std::vector<double> numbers{0.1, -0.0, 1e-320, std::numeric_limits<double>::infinity(), 5.0, 6.0};

  write_npy(folder / "matrix.npy", numbers, 3);
  write_npy(folder / "vector.npy", numbers);
  write_npy(folder / "empty.npy", {}, 3);

  EXPECT_EQ(read_npy(folder / "matrix.npy").shape, (Shape{2, 3}));
  EXPECT_EQ(read_npy(folder / "matrix.npy").numbers, numbers);
  EXPECT_EQ(read_npy(folder / "vector.npy").shape, (Shape{6}));
  EXPECT_EQ(read_npy(folder / "vector.npy").numbers, numbers);
  EXPECT_EQ(read_npy(folder / "empty.npy").shape, (Shape{0, 3}));
}

TEST(NpyTest, HeadersAreThoseOfTheFormat) {
  const Folder folder;

  write_npy(folder / "x.npy", std::vector<double>{1.0, 2.0, 3.0}, 3);

  const std::string text = read_text(folder / "x.npy");
  EXPECT_EQ(text.size(), 128u + 3 * sizeof(double)) << "the numbers begin at a multiple of 64";
  EXPECT_TRUE(text.starts_with(std::string("\x93NUMPY\x01\x00\x76\x00", 10)));
  EXPECT_EQ(text.find("{'descr': '<f8', 'fortran_order': False, 'shape': (1, 3), }"), 10u);
  EXPECT_EQ(text[127], '\n');
}

TEST(NpyTest, BooleansTakeAByteEach) {
  const Folder folder;

  write_npy_booleans(folder / "x.npy", {true, true, true});

  const std::string text = read_text(folder / "x.npy");
  EXPECT_NE(text.find("{'descr': '|b1', 'fortran_order': False, 'shape': (3,), }"), std::string::npos);
  EXPECT_TRUE(text.ends_with("\n\1\1\1"));
}

}  // namespace
}  // namespace tanor::report
