#include "statics/stiffness_matrix.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "base/groups.hpp"
#include "evaluate/force_derivatives.hpp"

namespace tanor::detail {

StiffnessMatrix::StiffnessMatrix(Workspace& work)
    : work_(work), model_(work.model()), point_positions_(model_.num_moving()), at_rest_(3 * model_.num_points(), 0.0) {
  std::vector<Coupling> couplings = work_.forces.list_couplings();
  num_springs_ = couplings.size();
  const std::vector<Coupling> rods = work_.constraints.list_rods();
  couplings.insert(couplings.end(), rods.begin(), rods.end());
  for (const Coupling& coupling : couplings) couplings_.push_back({coupling, -1, -1});
  make_pattern(nullptr);
  point_velocities_.resize(point_positions_.size());
  coupling_positions_.resize(couplings_.size());
  coupling_velocities_.resize(couplings_.size());
}

void StiffnessMatrix::make_pattern(const double* r) {
  ++pattern_version_;
  std::vector<Influence> influences = work_.forces.list_influences();
  num_energies_ = influences.size();
  const std::vector<Influence> curved = work_.constraints.list_curved();
  influences.insert(influences.end(), curved.begin(), curved.end());
  influences_.resize(influences.size());

  const int n = static_cast<int>(model_.num_moving());
  std::vector<std::pair<int, int>> entries;
  const auto add_both = [&](int i, int j) {  // both triangles have one pattern
    if (i < n && j < n) entries.insert(entries.end(), {{i, j}, {j, i}});
  };
  for (int i = 0; i < n; ++i) entries.push_back({i, i});
  for (const auto& [i, j] : influences) add_both(i, j);
  for (const CoupledBlocks& coupling : couplings_) add_both(coupling.points.i, coupling.points.j);
  num_pairs_ = 0;
  if (r != nullptr) {
    work_.forces.for_each_pair_stiffness(model_.parallel, r, [&](int i, int j, const Block3&) {
      ++num_pairs_;
      add_both(i, j);
    });
  }
  compress_pairs(static_cast<std::size_t>(n), std::move(entries), &start_, &columns_);
  blocks_.resize(columns_.size());

  diagonal_.clear();
  for (int i = 0; i < n; ++i) diagonal_.push_back(slot(i, i));
  for (CoupledBlocks& coupling : couplings_) {
    const auto [i, j] = coupling.points;
    if (i >= n || j >= n) continue;
    coupling.ij = slot(i, j);
    coupling.ji = slot(j, i);
  }
  influence_slots_.clear();
  for (const auto& [i, j] : influences) influence_slots_.push_back(i < n && j < n ? slot(i, j) : -1);
}

namespace {

void add(double sign, const Block3& from, Block3* to) {
  for (std::size_t entry = 0; entry < 9; ++entry) to->entries[entry] += sign * from.entries[entry];
}

}  // namespace

/// Returns true if the interacting pairs at r are those that the pattern was made for.
bool StiffnessMatrix::knows_all_pairs(const double* r) {
  std::size_t count = 0;
  bool has_all = true;
  const int n = static_cast<int>(num_points());
  work_.forces.for_each_pair_stiffness(model_.parallel, r, [&](int i, int j, const Block3&) {
    ++count;
    has_all = has_all && (i >= n || j >= n || slot(i, j) >= 0);
  });
  return has_all && count == num_pairs_;
}

void StiffnessMatrix::add_pairs(const double* r) {
  const int n = static_cast<int>(num_points());
  work_.forces.for_each_pair_stiffness(model_.parallel, r, [&](int i, int j, const Block3& derivative) {
    for (const int point : {i, j}) {
      if (point < n)
        add(-1.0, derivative, &blocks_[static_cast<std::size_t>(diagonal_[static_cast<std::size_t>(point)])]);
    }
    if (i >= n || j >= n) return;
    add(1.0, derivative, &blocks_[static_cast<std::size_t>(slot(i, j))]);
    add(1.0, derivative, &blocks_[static_cast<std::size_t>(slot(j, i))]);
  });
}

/// Adds a coupling: if B is the derivative of the force on j in r_j, W has -B at (i, i) and (j, j), and B at (i, j) and
/// (j, i).
void StiffnessMatrix::add_coupling(std::size_t k, const Block3& derivative, std::vector<Block3>* to) const {
  const auto& [points, ij, ji] = couplings_[k];
  for (const int point : {points.i, points.j}) {
    if (static_cast<std::size_t>(point) < diagonal_.size())
      add(-1.0, derivative, &(*to)[static_cast<std::size_t>(diagonal_[static_cast<std::size_t>(point)])]);
  }
  if (ij < 0) return;
  add(1.0, derivative, &(*to)[static_cast<std::size_t>(ij)]);
  add(1.0, derivative, &(*to)[static_cast<std::size_t>(ji)]);
}

void StiffnessMatrix::evaluate(double t, const double* r, const double* lambda, Curvature curvature) {
  work_.set_time(t);
  const Parallel& parallel = model_.parallel;
  std::fill(influences_.begin(), influences_.end(), Block3{});
  work_.forces.evaluate_derivatives(parallel, t, r, at_rest_.data(), nullptr,
                                    {point_positions_.data(), point_velocities_.data(), coupling_positions_.data(),
                                     coupling_velocities_.data(), influences_.data()});
  work_.constraints.evaluate_rod_derivatives(parallel, r, lambda, coupling_positions_.data() + num_springs_);
  work_.constraints.evaluate_curvatures(r, lambda, influences_.data() + num_energies_);

  if (!knows_all_pairs(r)) make_pattern(r);
  std::fill(blocks_.begin(), blocks_.end(), Block3{});
  add_pairs(r);
  for (std::size_t i = 0; i < diagonal_.size(); ++i)
    add(-1.0, point_positions_[i], &blocks_[static_cast<std::size_t>(diagonal_[i])]);
  for (std::size_t k = 0; k < couplings_.size(); ++k) {
    const Block3& derivative = coupling_positions_[k];
    // -(T/L)(I - u u') of a rod has the trace -2 T/L.
    const bool is_compressed = k >= num_springs_ && derivative(0, 0) + derivative(1, 1) + derivative(2, 2) > 0.0;
    if (curvature == Curvature::Exact || !is_compressed) add_coupling(k, derivative, &blocks_);
  }
  for (std::size_t k = 0; k < influences_.size(); ++k) {
    // Energies give df/dr; curved constraints give -lambda Hess xi, which already has the sign of W.
    const double sign = k < num_energies_ ? -1.0 : 1.0;
    if (influence_slots_[k] >= 0) add(sign, influences_[k], &blocks_[static_cast<std::size_t>(influence_slots_[k])]);
  }
}

Eigen::SparseMatrix<double> StiffnessMatrix::find_damping(double t, const double* r) const {
  DerivativeBlocks of(point_positions_.size(), couplings_.size(), influences_.size());
  work_.set_time(t);
  work_.forces.evaluate_derivatives(model_.parallel, t, r, at_rest_.data(), nullptr, of);
  std::vector<Block3> D(blocks_.size());
  for (std::size_t i = 0; i < diagonal_.size(); ++i)
    add(-1.0, of.point_velocities[i], &D[static_cast<std::size_t>(diagonal_[i])]);
  for (std::size_t k = 0; k < num_springs_; ++k) add_coupling(k, of.coupling_velocities[k], &D);
  for (std::size_t k = 0; k < num_energies_; ++k) {
    if (influence_slots_[k] >= 0)
      add(-1.0, of.influence_velocities[k], &D[static_cast<std::size_t>(influence_slots_[k])]);
  }
  std::vector<Eigen::Triplet<double>> entries;
  for_each_block([&](std::size_t i, std::size_t j, std::size_t k) {
    for (int entry = 0; entry < 9; ++entry)
      entries.emplace_back(3 * static_cast<int>(i) + entry / 3, 3 * static_cast<int>(j) + entry % 3,
                           D[k](entry / 3, entry % 3));
  });
  const auto size = static_cast<Eigen::Index>(3 * num_points());
  Eigen::SparseMatrix<double> result(size, size);
  result.setFromTriplets(entries.begin(), entries.end());
  return result;
}

void StiffnessMatrix::add_tension(double tension, const double* r) {
  constexpr double little =
      1e-3;  // points with rods also get this part of the tension, so that floating islands are held
  std::vector<char> has_rod(num_points(), 0);
  for (std::size_t k = num_springs_; k < couplings_.size(); ++k) {
    const auto [i, j] = couplings_[k].points;
    Block3 derivative;
    derivative.add_identity(-tension / std::max(norm(load(r, j) - load(r, i)), little * model_.smallest_length));
    add_coupling(k, derivative, &blocks_);
    for (const int point : {i, j}) {
      if (static_cast<std::size_t>(point) < has_rod.size()) has_rod[static_cast<std::size_t>(point)] = 1;
    }
  }
  for (std::size_t i = 0; i < num_points(); ++i)
    blocks_[static_cast<std::size_t>(diagonal_[i])].add_identity((has_rod[i] != 0 ? little : 1.0) * tension /
                                                                 model_.scene_size);
}

void StiffnessMatrix::hold_rows(double share, double otherwise) {
  for (std::size_t i = 0; i < num_points(); ++i) {
    Block3& own = blocks_[static_cast<std::size_t>(diagonal_[i])];
    std::array<double, 3> most{};
    for (int k = start_[i]; k < start_[i + 1]; ++k) {
      const Block3& block = blocks_[static_cast<std::size_t>(k)];
      for (int row = 0; row < 3; ++row) {
        double& entry = most[static_cast<std::size_t>(row)];
        for (int column = 0; column < 3; ++column) entry = larger(entry, std::abs(block(row, column)));
      }
    }
    for (int row = 0; row < 3; ++row) {
      const double entry = most[static_cast<std::size_t>(row)];
      own.entries[static_cast<std::size_t>(4 * row)] += entry > 0.0 ? share * entry : otherwise;
    }
  }
}

void StiffnessMatrix::multiply(const double* x, double* y) const {
  model_.parallel.for_ranges(num_points(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      Vec3 sum{};
      for (int k = start_[i]; k < start_[i + 1]; ++k)
        sum = sum + blocks_[static_cast<std::size_t>(k)] * load(x, columns_[static_cast<std::size_t>(k)]);
      store(y, i, sum);
    }
  });
}

Eigen::MatrixXd StiffnessMatrix::multiply(const Eigen::MatrixXd& X) const {
  Eigen::MatrixXd result(X.rows(), X.cols());
  for (Eigen::Index j = 0; j < X.cols(); ++j) multiply(X.col(j).data(), result.col(j).data());
  return result;
}

StiffnessMatrix::Work StiffnessMatrix::find_work(const double* y, const double* z,
                                                 const StiffnessMatrix* without) const {
  Work result;
  for_each_block([&](std::size_t i, std::size_t j, std::size_t k) {
    for (std::size_t entry = 0; entry < 9; ++entry) {
      const double less = without != nullptr ? without->blocks_[k].entries[entry] : 0.0;
      const double term = y[3 * i + entry / 3] * (blocks_[k].entries[entry] - less) * z[3 * j + entry % 3];
      result.sum += term;
      result.terms += std::abs(term);
    }
  });
  return result;
}

std::vector<double> StiffnessMatrix::sum_rows() const {
  std::vector<std::array<double, 3>> sums(num_points());
  for_each_block([&](std::size_t i, std::size_t, std::size_t k) {
    for (std::size_t entry = 0; entry < 9; ++entry) sums[i][entry / 3] += std::abs(blocks_[k].entries[entry]);
  });
  std::vector<double> result;
  for (const std::array<double, 3>& each : sums) result.push_back(std::ranges::max(each));
  return result;
}

double StiffnessMatrix::asymmetry() const {
  double worst = 0.0;
  for_each_block([&](std::size_t i, std::size_t j, std::size_t k) {
    const Block3& other = blocks_[static_cast<std::size_t>(slot(static_cast<int>(j), static_cast<int>(i)))];
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 3; ++column)
        worst = larger(worst, std::abs(blocks_[k](row, column) - other(column, row)));
    }
  });
  const double scale = largest();
  return scale > 0.0 ? worst / scale : 0.0;
}

double StiffnessMatrix::largest_of(std::size_t point) const {
  double result = 0.0;
  for (int k = start_[point]; k < start_[point + 1]; ++k) {
    for (const double entry : blocks_[static_cast<std::size_t>(k)].entries) result = larger(result, std::abs(entry));
  }
  return result;
}

double StiffnessMatrix::largest() const {
  double result = 0.0;
  for (std::size_t i = 0; i < num_points(); ++i) result = larger(result, largest_of(i));
  return result;
}

}  // namespace tanor::detail
