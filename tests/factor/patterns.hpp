#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>
#include <utility>
#include <vector>

#include "factor/cholesky.hpp"
#include "factor/sparse_qr.hpp"

/// \file Rods between points, the pattern of their S = K'K and the unit columns of K.
namespace tanor::patterns {
using namespace detail;

struct Rods {
  int num_points = 0;
  std::vector<std::pair<int, int>> ends;
  std::vector<double> positions{};  // [3 points] for nets and lattices, 1 apart
};

inline Rods make_net(int columns, int rows) {
  Rods rods{columns * rows, {}};
  for (int i = 0; i < columns; ++i) {
    for (int j = 0; j < rows; ++j) {
      rods.positions.insert(rods.positions.end(), {static_cast<double>(i), static_cast<double>(j), 0.0});
      if (i + 1 < columns) rods.ends.emplace_back(i * rows + j, (i + 1) * rows + j);
      if (j + 1 < rows) rods.ends.emplace_back(i * rows + j, i * rows + j + 1);
    }
  }
  return rods;
}

inline Rods make_lattice(int side) {
  Rods rods{side * side * side, {}};
  const auto point = [&](int x, int y, int z) { return (x * side + y) * side + z; };
  for (int x = 0; x < side; ++x) {
    for (int y = 0; y < side; ++y) {
      for (int z = 0; z < side; ++z) {
        for (const int place : {x, y, z}) rods.positions.push_back(place);
        if (x + 1 < side) rods.ends.emplace_back(point(x, y, z), point(x + 1, y, z));
        if (y + 1 < side) rods.ends.emplace_back(point(x, y, z), point(x, y + 1, z));
        if (z + 1 < side) rods.ends.emplace_back(point(x, y, z), point(x, y, z + 1));
      }
    }
  }
  return rods;
}

/// Makes rods as in a protein whose bonds and angles are rigid, with a backbone and side chains, a bridge here and
/// there, and rods between the neighbours of each atom.
inline Rods make_protein(int residues, std::uint32_t seed) {
  std::mt19937 generator(seed);
  std::vector<std::vector<int>> bonded;
  std::vector<std::pair<int, int>> ends;
  const auto join = [&](int a, int b) {
    ends.emplace_back(a, b);
    bonded[static_cast<std::size_t>(a)].push_back(b);
    bonded[static_cast<std::size_t>(b)].push_back(a);
  };
  const auto add = [&](int to) {
    bonded.emplace_back();
    const int atom = static_cast<int>(bonded.size()) - 1;
    if (to >= 0) join(to, atom);
    return atom;
  };
  std::vector<int> tips;
  int last = -1;
  for (int residue = 0; residue < residues; ++residue) {
    const int backbone = add(last), alpha = add(backbone);
    last = add(alpha);
    int tip = alpha;
    for (auto k = generator() % 5; k > 0; --k) {
      tip = add(tip);
      for (auto hydrogens = generator() % 3; hydrogens > 0; --hydrogens) add(tip);
    }
    tips.push_back(tip);
    if (residue % 9 == 8) join(tips[generator() % (tips.size() - 1)], tip);
  }
  for (const std::vector<int>& around : bonded) {
    for (std::size_t a = 0; a < around.size(); ++a)
      for (std::size_t b = 0; b < a; ++b) ends.emplace_back(around[b], around[a]);
  }
  return {static_cast<int>(bonded.size()), std::move(ends)};
}

/// Makes rods between near points of a cloud, about six at each end, in a network without any grid.
inline Rods make_cloud(int num_points, std::uint32_t seed) {
  std::mt19937 generator(seed);
  const double side = std::cbrt(static_cast<double>(num_points));
  std::uniform_real_distribution<double> inside(0.0, side);
  Rods rods{num_points, {}};
  for (int k = 0; k < 3 * num_points; ++k) rods.positions.push_back(inside(generator));
  std::vector<int> along(static_cast<std::size_t>(num_points));  // points along the first axis
  for (int k = 0; k < num_points; ++k) along[static_cast<std::size_t>(k)] = k;
  const auto at = [&](int point, int axis) { return rods.positions[static_cast<std::size_t>(3 * point + axis)]; };
  std::ranges::sort(along, {}, [&](int point) { return at(point, 0); });
  constexpr double reach = 1.42;  // twelve of a point's neighbours are nearer
  for (std::size_t k = 0; k < along.size(); ++k) {
    for (std::size_t q = k + 1; q < along.size() && at(along[q], 0) - at(along[k], 0) < reach; ++q) {
      double square = 0.0;
      for (const int axis : {0, 1, 2}) square += std::pow(at(along[q], axis) - at(along[k], axis), 2);
      if (square < reach * reach) rods.ends.emplace_back(along[k], along[q]);
    }
  }
  return rods;
}

/// Returns the points that rods join, moved by up to `noise` along each axis.
inline RowsInSpace points_of(const Rods& rods, double noise = 0.0) {
  std::mt19937 generator(1);
  std::uniform_real_distribution<double> any(-noise, noise);
  RowsInSpace result{{}, rods.positions};
  for (double& x : result.positions) x += any(generator);
  for (const auto& [a, b] : rods.ends) {
    result.points_of_row.entries.insert(result.points_of_row.entries.end(), {a, b});
    result.points_of_row.end_group();
  }
  return result;
}

/// Returns the lower triangle of S with its rows in the given order.
inline TrianglePattern pattern_of(const Rods& rods, const std::vector<int>& order = {}) {
  const auto d = rods.ends.size();
  std::vector<int> place(d);
  for (std::size_t k = 0; k < d; ++k)
    place[order.empty() ? k : static_cast<std::size_t>(order[k])] = static_cast<int>(k);
  std::vector<std::vector<int>> at(static_cast<std::size_t>(rods.num_points)), below(d);
  for (std::size_t k = 0; k < d; ++k) {
    at[static_cast<std::size_t>(rods.ends[k].first)].push_back(place[k]);
    at[static_cast<std::size_t>(rods.ends[k].second)].push_back(place[k]);
  }
  for (const std::vector<int>& there : at) {
    for (const int i : there) {
      for (const int j : there)
        if (i >= j) below[static_cast<std::size_t>(j)].push_back(i);
    }
  }
  TrianglePattern pattern;
  for (std::vector<int>& column : below) {
    std::ranges::sort(column);
    column.erase(std::unique(column.begin(), column.end()), column.end());
    pattern.rows.insert(pattern.rows.end(), column.begin(), column.end());
    pattern.start.push_back(static_cast<int>(pattern.rows.size()));
  }
  return pattern;
}

/// Returns columns (d, -d) of unit length between points at random places. If `flat`, the points lie in a plane.
inline SparseColumns gradients_of(const Rods& rods, std::uint32_t seed, bool flat = false) {
  std::mt19937 generator(seed);
  std::uniform_real_distribution<double> anywhere(-1.0, 1.0);
  std::vector<double> r(3 * static_cast<std::size_t>(rods.num_points));
  for (std::size_t k = 0; k < r.size(); ++k) r[k] = flat && k % 3 == 2 ? 0.0 : anywhere(generator);
  SparseColumns C;
  C.num_rows = 3 * rods.num_points;
  for (const auto& [a, b] : rods.ends) {
    const auto [first, second] = std::minmax(a, b);
    double d[3], square = 0.0;
    for (int c = 0; c < 3; ++c) {
      d[c] = r[static_cast<std::size_t>(3 * first + c)] - r[static_cast<std::size_t>(3 * second + c)];
      square += d[c] * d[c];
    }
    for (const int point : {first, second}) {
      for (int c = 0; c < 3; ++c) {
        C.rows.push_back(3 * point + c);
        C.values.push_back((point == first ? d[c] : -d[c]) / std::sqrt(2.0 * square));
      }
    }
    C.start.push_back(static_cast<int>(C.rows.size()));
  }
  return C;
}

}  // namespace tanor::patterns
