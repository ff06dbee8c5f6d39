#include "scene/npy.hpp"

#include <limits>

#include <gtest/gtest.h>
#include <tanor/error.hpp>

namespace tanor::scene {
namespace {

using Shape = std::vector<std::size_t>;

/// Returns a file of version 1 or 2 (where the header's length takes 4 bytes).
std::string make_npy(const std::string& header, const std::vector<double>& numbers, char version = 1) {
  std::string text = std::string("\x93NUMPY") + version + '\0' + static_cast<char>(header.size()) + '\0';
  if (version > 1) text += std::string(2, '\0');
  return (text + header).append(reinterpret_cast<const char*>(numbers.data()), numbers.size() * sizeof(double));
}

std::string header(const std::string& shape) {
  return "{'descr': '<f8', 'fortran_order': False, 'shape': " + shape + ", }\n";
}

std::string npy_error(const std::string& content) {
  std::string_view bytes = content;
  try {
    read_npy("x.npy", &bytes);
  } catch (const InputError& error) {
    EXPECT_EQ(error.where(), "x.npy");
    EXPECT_EQ(bytes.size(), content.size()) << "nothing is taken";
    return error.what();
  }
  return "no error";
}

TEST(NpyTest, TakesOneArrayAfterTheOther) {
  const double infinity = std::numeric_limits<double>::infinity();
  const std::string text = make_npy(header("(2, 3)"), {1, 2, 3, 4, 5, infinity}) + make_npy(header("(0, 3)"), {}) +
                           make_npy(header("(1,)"), {1e-320}, 2) + "rest";
  std::string_view bytes = text;

  const NpyArray matrix = read_npy("x.npy", &bytes), empty = read_npy("x.npy", &bytes),
                 number = read_npy("x.npy", &bytes);

  EXPECT_EQ(matrix.shape, (Shape{2, 3}));
  EXPECT_EQ(matrix.numbers, (std::vector<double>{1, 2, 3, 4, 5, infinity}));
  EXPECT_EQ(empty.shape, (Shape{0, 3}));
  EXPECT_EQ(empty.numbers, std::vector<double>());
  EXPECT_EQ(number.shape, (Shape{1}));
  EXPECT_EQ(number.numbers, std::vector<double>{1e-320});
  EXPECT_EQ(bytes, "rest");
}

TEST(NpyTest, OtherFilesAreRefused) {
  const std::vector<double> four(4);

  EXPECT_EQ(npy_error(make_npy(header("(2, 2)"), four)), "no error");
  EXPECT_EQ(npy_error("PK\3\4 an archive"), "wanted a NumPy file");
  EXPECT_EQ(npy_error(make_npy(header("(2, 2)"), {}).substr(0, 40)), "wanted a NumPy file with a whole header");
  EXPECT_EQ(npy_error(make_npy("{'descr': '>f8', 'fortran_order': False, 'shape': (2, 2), }\n", four)),
            "wanted numbers of type '<f8' (float64)");
  EXPECT_EQ(npy_error(make_npy("{'descr': '<f8', 'fortran_order': True, 'shape': (2, 2), }\n", four)),
            "wanted an array in C order");
  EXPECT_EQ(npy_error(make_npy("{'descr': '<f8', 'fortran_order': False, }\n", four)),
            "wanted a shape of whole numbers, one or more");
  for (const char* shape : {"()", "(-2, 2)", "(two,)", "(2", "(2, , 2)"}) {
    EXPECT_EQ(npy_error(make_npy(header(shape), four)), "wanted a shape of whole numbers, one or more") << shape;
  }
  for (const char* shape : {"(5,)", "(4294967296, 4294967296)", "(4294967296, 4294967296, 4294967296)"}) {
    EXPECT_EQ(npy_error(make_npy(header(shape), four)), "wanted as many numbers as its shape says") << shape;
  }
}

}  // namespace
}  // namespace tanor::scene
