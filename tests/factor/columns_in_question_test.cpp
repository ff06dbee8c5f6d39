/// The rods that may depend on others at all are held against nets whose self-stresses are known and against dense null
/// spaces.

#include "factor/dependent_columns.hpp"

#include <algorithm>
#include <numeric>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>
#include <Eigen/Dense>

#include "dense.hpp"
#include "patterns.hpp"

namespace tanor {
using namespace detail;
namespace {

using namespace patterns;
using Matrix = Eigen::MatrixXd;
using Groups = std::vector<std::vector<int>>;

constexpr double tolerance = 1e-12;

/// Returns unit gradients of rods with the ends at `places`, [3 x points]. `fixed` points take no part.
SparseColumns columns(const Rods& rods, const Matrix& places, const std::vector<int>& fixed) {
  SparseColumns C;
  C.num_rows = static_cast<int>(3 * places.cols());
  const auto is_fixed = [&](int point) { return std::ranges::find(fixed, point) != fixed.end(); };
  for (const auto& [a, b] : rods.ends) {
    const Eigen::Vector3d along = (places.col(b) - places.col(a)).normalized();
    const double scale = is_fixed(a) || is_fixed(b) ? 1.0 : std::sqrt(0.5);
    for (const auto& [point, sign] :
         {std::pair{std::min(a, b), a < b ? -1.0 : 1.0}, {std::max(a, b), a < b ? 1.0 : -1.0}}) {
      if (is_fixed(point)) continue;
      for (int c = 0; c < 3; ++c) {
        C.rows.push_back(3 * point + c);
        C.values.push_back(sign * scale * along[c]);
      }
    }
    C.start.push_back(static_cast<int>(C.rows.size()));
  }
  return C;
}

Matrix places_of(const Rods& rods) {
  return Matrix::Map(rods.positions.data(), 3, rods.num_points);
}

/// The groups are the same however a net is turned.
const Matrix turn = Eigen::AngleAxisd(0.7, Eigen::Vector3d(1.0, 2.0, 3.0).normalized()).toRotationMatrix();

/// Returns the rods of a net with both ends in one of the lines.
std::vector<int> rods_along(const Rods& net, int size, int line) {
  std::vector<int> result;
  for (std::size_t k = 0; k < net.ends.size(); ++k) {
    const auto& [a, b] = net.ends[k];
    if (a / size == line && b / size == line) result.push_back(static_cast<int>(k));
  }
  return result;
}

TEST(ColumnsInQuestion, AreTheRodsBetweenTheTwoHeldCornersOfAFlatNet) {
  constexpr int size = 40;
  const Rods net = make_net(size, size);
  EXPECT_EQ(find_columns_in_question(columns(net, turn * places_of(net), {0, size - 1}), tolerance),
            Groups{rods_along(net, size, 0)});
  EXPECT_EQ(find_columns_in_question(columns(net, turn * places_of(net), {0, size * size - 1}), tolerance), Groups{})
      << "held by opposite corners it has no self-stress";
}

TEST(ColumnsInQuestion, FallIntoGroupsThatShareNoPoint) {
  constexpr int size = 12;
  const Rods net = make_net(size, size);
  std::vector<int> fixed;
  Groups lines;
  for (int line = 0; line < size; ++line) {
    fixed.insert(fixed.end(), {size * line, size * line + size - 1});
    lines.push_back(rods_along(net, size, line));
  }
  // Along the held edges rods hang on points that cannot move. Each is a line of its own, which no point joins to
  // others.
  Groups found = find_columns_in_question(columns(net, turn * places_of(net), fixed), tolerance);
  std::erase_if(found, [](const std::vector<int>& group) { return group.size() == 1; });
  std::ranges::sort(found);
  std::ranges::sort(lines);
  EXPECT_EQ(found, lines);
}

// A bend of 1e-11 separates the rods of a line only to within rounding, so that QR must decide.
TEST(ColumnsInQuestion, IncludeRodsThatRoundingMayHaveToldApart) {
  constexpr int size = 10;
  const Rods line = make_net(1, size);
  Matrix places = turn * places_of(line);
  places(0, size / 2) += 1e-11;
  EXPECT_EQ(find_columns_in_question(columns(line, places, {0, size - 1}), tolerance).size(), 1U);
  places(0, size / 2) += 1e-3;
  EXPECT_TRUE(find_columns_in_question(columns(line, places, {0, size - 1}), tolerance).empty());
}

/// The rods are those of a flat net braced at random, some points held, with a cloud of rods in space hanging on it.
RC_GTEST_PROP(ColumnsInQuestion, HoldEverySelfStressWhole, ()) {
  std::mt19937 generator(*rc::gen::arbitrary<std::uint32_t>());
  const int size = 3 + static_cast<int>(generator() % 4), flat = size * size;
  Rods rods = make_net(size, size);
  for (int k = 0; k < size * size / 2; ++k) {
    const int a = static_cast<int>(generator() % static_cast<unsigned>(flat));
    const int b = static_cast<int>(generator() % static_cast<unsigned>(flat));
    if (a != b) rods.ends.emplace_back(a, b);
  }
  std::uniform_real_distribution<double> any(-1.0, 1.0);
  for (int k = 0; k < 10; ++k) {
    const int point = rods.num_points++;
    rods.positions.insert(rods.positions.end(), {any(generator), any(generator), any(generator)});
    for (unsigned joints = 1 + generator() % 4; joints > 0; --joints)
      rods.ends.emplace_back(static_cast<int>(generator() % static_cast<unsigned>(point)), point);
  }
  const std::vector<int> fixed{0, size - 1, static_cast<int>(generator() % static_cast<unsigned>(flat))};
  SparseColumns C = columns(rods, turn * places_of(rods), fixed);

  Matrix dense = Matrix::Zero(C.num_rows, static_cast<Eigen::Index>(C.num_columns()));
  for (std::size_t j = 0; j < C.num_columns(); ++j)
    for_each_entry(C, static_cast<int>(j),
                   [&](int row, double value) { dense(row, static_cast<Eigen::Index>(j)) = value; });
  Matrix V;
  const auto rank = (reference::singular_values(dense, &V).array() > 1e-10).count();
  const Matrix null = V.rightCols(dense.cols() - rank);

  std::vector<int> group_of(C.num_columns(), -1);
  const Groups groups = find_columns_in_question(C, tolerance);
  for (std::size_t g = 0; g < groups.size(); ++g)
    for (const int column : groups[g]) group_of[static_cast<std::size_t>(column)] = static_cast<int>(g);
  // The null space is the sum of those of the groups, so that its projector has no entry between two groups or outside
  // them.
  const Matrix projector = null * null.transpose();
  for (Eigen::Index i = 0; i < dense.cols(); ++i) {
    for (Eigen::Index j = 0; j < dense.cols(); ++j) {
      if (std::abs(projector(i, j)) < 1e-8) continue;
      RC_ASSERT(group_of[static_cast<std::size_t>(i)] >= 0);
      RC_ASSERT(group_of[static_cast<std::size_t>(i)] == group_of[static_cast<std::size_t>(j)]);
    }
  }
}

}  // namespace
}  // namespace tanor
