#include "statics/rigid_modes.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <optional>

#include "base/dense.hpp"

namespace tanor {

namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;

/// Six motions of every island at once: shifts along the axes, and turns about its centre, all of unit size.
struct RigidFields {
  RigidFields(const std::vector<int>& island, const double* r);

  std::vector<double> count, radius;         // [island] number of points, and their largest distance from the centre
  std::vector<Vec3> centre;                  // [island]
  std::array<std::vector<double>, 6> moves;  // [3 points]
};

RigidFields::RigidFields(const std::vector<int>& island, const double* r)
    : count(island.size(), 0.0), radius(island.size(), 0.0), centre(island.size()) {
  const auto own = [&](std::size_t i) { return static_cast<std::size_t>(island[i]); };
  for (std::size_t i = 0; i < island.size(); ++i) {
    centre[own(i)] = centre[own(i)] + load(r, i);
    count[own(i)] += 1.0;
  }
  for (std::size_t k = 0; k < centre.size(); ++k) {
    if (count[k] > 0.0) centre[k] = (1.0 / count[k]) * centre[k];
  }
  const auto arm = [&](std::size_t i) { return load(r, i) - centre[own(i)]; };
  for (std::size_t i = 0; i < island.size(); ++i) radius[own(i)] = std::max(radius[own(i)], norm(arm(i)));
  constexpr std::array<Vec3, 3> axes{Vec3{1.0, 0.0, 0.0}, Vec3{0.0, 1.0, 0.0}, Vec3{0.0, 0.0, 1.0}};
  for (std::size_t k = 0; k < 6; ++k) {
    moves[k].assign(3 * island.size(), 0.0);
    for (std::size_t i = 0; i < island.size(); ++i) {
      if (k < 3)
        store(moves[k].data(), i, axes[k]);
      else if (radius[own(i)] > 0.0)
        store(moves[k].data(), i, (1.0 / radius[own(i)]) * cross(axes[k - 3], arm(i)));
    }
  }
}

/// Adds the scalar products of six vectors at one point or row.
template <class Product>
void add_products(Matrix6* to, const Product& product) {
  for (std::size_t a = 0; a < 6; ++a) {
    for (std::size_t b = 0; b < 6; ++b) (*to)(static_cast<int>(a), static_cast<int>(b)) += product(a, b);
  }
}

/// Combinations of the six motions of an island, by columns.
struct RigidMotions {
  Eigen::MatrixXd unanswered;  // moves of 1 m (root mean square) that nothing answers to
  Eigen::MatrixXd idle;        // motions that move no point: turns about the line of all of them
};

/// Finds candidates only, up to what rounding may hide: squares lose small answers where a turn moves points little.
RigidMotions find_candidates(const Matrix6& moves, const Matrix6& answers, double nothing) {
  const dense::SymmetricEigen eigen = dense::find_eigen(moves);
  const Eigen::Index num_idle = (eigen.values.array() < 1e-10).count();
  const Eigen::VectorXd squares = eigen.values.tail(6 - num_idle);
  const Eigen::MatrixXd basis = eigen.vectors.rightCols(6 - num_idle) * squares.cwiseSqrt().cwiseInverse().asDiagonal();
  const dense::SymmetricEigen answer = dense::find_eigen(basis.transpose() * answers * basis);
  const double hidden = nothing / std::min(1.0, squares.minCoeff());
  return {basis * answer.vectors.leftCols((answer.values.array() < hidden).count()), eigen.vectors.leftCols(num_idle)};
}

/// The answers to small motions u of islands: W u over the island's stiffness, and K'u.
class AnswersToMotions {
 public:
  AnswersToMotions(const EquilibriumEquations& equations, const std::vector<int>& island, const RigidFields& fields)
      : island_(island), fields_(fields), of_row_(equations.model().num_rows(), -1) {
    const std::size_t n = island.size();
    const std::vector<double> stiffness = find_island_stiffness(equations, island);
    for (std::size_t a = 0; a < 6; ++a) {
      forces_[a].resize(3 * n);
      rows_[a].resize(of_row_.size());
      equations.stiffness().multiply(fields.moves[a].data(), forces_[a].data());
      equations.apply_transposed(fields.moves[a].data(), rows_[a].data());
      for (std::size_t i = 0; i < n; ++i)
        store(forces_[a].data(), i, (1.0 / stiffness[i]) * load(forces_[a].data(), i));
    }
    for (const Incidence& incidence : equations.model().incidences) {
      if (static_cast<std::size_t>(incidence.point) < n)
        of_row_[static_cast<std::size_t>(incidence.row)] = island[static_cast<std::size_t>(incidence.point)];
    }
  }

  /// Returns the motions of each island that nothing answers to [island].
  std::vector<RigidMotions> find_unanswered() const {
    constexpr double nothing = 1e-14;  // of squares
    const std::size_t n = island_.size();
    std::vector<Matrix6> moves(n, Matrix6::Zero()), answers(n, Matrix6::Zero());
    for (std::size_t i = 0; i < n; ++i) {
      const auto own = static_cast<std::size_t>(island_[i]);
      add_products(&moves[own], [&](std::size_t a, std::size_t b) {
        return dot(load(fields_.moves[a].data(), i), load(fields_.moves[b].data(), i)) / fields_.count[own];
      });
      add_products(&answers[own], [&](std::size_t a, std::size_t b) {
        return dot(load(forces_[a].data(), i), load(forces_[b].data(), i));
      });
    }
    for (std::size_t row = 0; row < of_row_.size(); ++row) {
      if (of_row_[row] < 0) continue;
      add_products(&answers[static_cast<std::size_t>(of_row_[row])],
                   [&](std::size_t a, std::size_t b) { return rows_[a][row] * rows_[b][row]; });
    }
    std::vector<RigidMotions> motions(n);
    for (std::size_t own = 0; own < n; ++own) {
      if (fields_.count[own] > 0.0)
        motions[own] = find_candidates(moves[own], answers[own], nothing * fields_.count[own]);
    }
    keep_unanswered(nothing, &motions);
    return motions;
  }

 private:
  /// Keeps the candidates whose answers vanish when they are summed before they are squared.
  void keep_unanswered(double nothing, std::vector<RigidMotions>* motions) const {
    std::vector<Eigen::VectorXd> answered(island_.size());
    for (std::size_t own = 0; own < island_.size(); ++own)
      answered[own] = Eigen::VectorXd::Zero((*motions)[own].unanswered.cols());
    for (std::size_t i = 0; i < island_.size(); ++i) {
      const auto own = static_cast<std::size_t>(island_[i]);
      for (Eigen::Index k = 0; k < answered[own].size(); ++k) {
        Vec3 sum{};
        for (std::size_t a = 0; a < 6; ++a)
          sum = sum + (*motions)[own].unanswered(static_cast<int>(a), k) * load(forces_[a].data(), i);
        answered[own][k] += dot(sum, sum);
      }
    }
    for (std::size_t row = 0; row < of_row_.size(); ++row) {
      if (of_row_[row] < 0) continue;
      const auto own = static_cast<std::size_t>(of_row_[row]);
      for (Eigen::Index k = 0; k < answered[own].size(); ++k) {
        double sum = 0.0;
        for (std::size_t a = 0; a < 6; ++a) sum += (*motions)[own].unanswered(static_cast<int>(a), k) * rows_[a][row];
        answered[own][k] += sum * sum;
      }
    }
    for (std::size_t own = 0; own < island_.size(); ++own) {
      Eigen::MatrixXd& columns = (*motions)[own].unanswered;
      Eigen::Index kept = 0;
      for (Eigen::Index k = 0; k < columns.cols(); ++k) {
        if (answered[own][k] < nothing * fields_.count[own]) columns.col(kept++) = columns.col(k).eval();
      }
      columns.conservativeResize(Eigen::NoChange, kept);
    }
  }

  const std::vector<int>& island_;
  const RigidFields& fields_;
  std::array<std::vector<double>, 6> forces_, rows_;  // [3 points], [row]
  std::vector<int> of_row_;                           // [row] its island, -1: it joins no moving points
};

/// Carries points along u(x) = shift + turn x (x - c) for 1 s (exponential of a twist).
class Screw {
 public:
  Screw(Vec3 shift, Vec3 turn) : turn_(turn) {
    const double angle = norm(turn);
    if (angle > 1e-4) {
      first_ = std::sin(angle) / angle;
      second_ = (1.0 - std::cos(angle)) / (angle * angle);
      third_ = (1.0 - first_) / (angle * angle);
    }
    shift_ = shift + second_ * cross(turn, shift) + third_ * cross(turn, cross(turn, shift));
  }
  Vec3 rotate(Vec3 a) const { return a + first_ * cross(turn_, a) + second_ * cross(turn_, cross(turn_, a)); }
  Vec3 carry(Vec3 arm) const { return rotate(arm) + shift_; }

 private:
  Vec3 turn_, shift_;
  double first_ = 1.0, second_ = 0.5, third_ = 1.0 / 6.0;
};

/// Finite motions of islands.
class FiniteMotions {
 public:
  FiniteMotions(const EquilibriumEquations& equations, const std::vector<double>& r, const std::vector<int>& island,
                const RigidFields& fields, std::vector<RigidMotions>* motions)
      : equations_(equations),
        r_(r),
        island_(island),
        fields_(fields),
        motions_(*motions),
        before_(forces_at(r)),
        stiffness_(find_island_stiffness(equations, island)) {}

  /// Counts the unanswered motions that leave the forces of their island unchanged, turned with it, also over a finite
  /// distance. An infinitesimal motion is not enough: at the top of -x^4 nothing answers to it.
  std::size_t count_free() {
    std::size_t result = 0;
    for (Eigen::Index k = 0; k < 6; ++k) result += count_free(k);
    (void)forces_at(r_);  // restores the forces that others may read
    return result;
  }

 private:
  bool moves(std::size_t own, Eigen::Index k) const { return k < motions_[own].unanswered.cols(); }
  std::size_t own(std::size_t i) const { return static_cast<std::size_t>(island_[i]); }

  std::vector<double> forces_at(const std::vector<double>& at) const {
    std::vector<double> f(at.size(), 0.0);
    const std::vector<double> at_rest(at.size(), 0.0);
    equations_.work().forces.evaluate(equations_.model().parallel, equations_.time(), at.data(), at_rest.data(),
                                      f.data());
    return f;
  }

  /// Returns the size of motion k of an island: a tenth of its radius, or of a radian.
  double find_size(std::size_t each, Eigen::Index k) const {
    constexpr double part = 0.1;
    const double radius = std::max(fields_.radius[each], equations_.model().smallest_length);
    return part * radius / std::max(1.0, motions_[each].unanswered.col(k).tail<3>().norm());
  }

  /// Returns the forces after motion k of all islands by `sizes`, less the earlier ones turned with them [3 points], N.
  std::vector<double> change_of_forces(Eigen::Index k, const std::vector<double>& sizes) const {
    std::vector<std::optional<Screw>> screws(island_.size());
    for (std::size_t each = 0; each < island_.size(); ++each) {
      if (!moves(each, k)) continue;
      const auto c = motions_[each].unanswered.col(k);
      const double radius = fields_.radius[each], turn = radius > 0.0 ? sizes[each] / radius : 0.0;
      screws[each].emplace(sizes[each] * Vec3{c[0], c[1], c[2]}, turn * Vec3{c[3], c[4], c[5]});
    }
    std::vector<double> moved = r_;
    for (std::size_t i = 0; i < island_.size(); ++i) {
      const Vec3 centre = fields_.centre[own(i)];
      if (const auto& screw = screws[own(i)])
        store(moved.data(), i, centre + screw->carry(load(r_.data(), i) - centre));
    }
    std::vector<double> change = forces_at(moved);
    for (std::size_t i = 0; i < island_.size(); ++i) {
      if (const auto& screw = screws[own(i)])
        store(change.data(), i, load(change.data(), i) - screw->rotate(load(before_.data(), i)));
    }
    return change;
  }

  /// Adds a turn about the line of all points of an island. It moves no point at first order, but it decides about
  /// which axis they go on and where forces turn to. The Gauss-Newton method chooses the amount that changes forces
  /// least.
  void choose_idle_turns(Eigen::Index k, const std::vector<double>& sizes) {
    constexpr int steps = 8;
    constexpr double small = 1e-4;
    const auto turns = [&](std::size_t each) { return moves(each, k) && motions_[each].idle.cols() == 1; };
    const auto turn = [&](const std::vector<double>& by) {
      for (std::size_t each = 0; each < by.size(); ++each) {
        if (turns(each)) motions_[each].unanswered.col(k) += by[each] * motions_[each].idle.col(0);
      }
    };
    bool any = false;
    for (std::size_t each = 0; each < island_.size(); ++each) any = any || turns(each);
    for (int step = 0; any && step < steps; ++step) {
      const std::vector<double> here = change_of_forces(k, sizes);
      turn(std::vector<double>(island_.size(), small));
      const std::vector<double> there = change_of_forces(k, sizes);
      std::vector<double> slope2(island_.size(), 0.0), along(island_.size(), 0.0), by(island_.size(), -small);
      for (std::size_t i = 0; i < island_.size(); ++i) {
        const Vec3 slope = (1.0 / small) * (load(there.data(), i) - load(here.data(), i));
        slope2[own(i)] += dot(slope, slope);
        along[own(i)] += dot(slope, load(here.data(), i));
      }
      for (std::size_t each = 0; each < by.size(); ++each) {
        if (slope2[each] > 0.0) by[each] -= along[each] / slope2[each];
      }
      turn(by);
    }
  }

  std::size_t count_free(Eigen::Index k) {
    constexpr double digits = 1e-7;
    std::vector<double> sizes(island_.size(), 0.0), largest(island_.size(), 0.0), most(island_.size(), 0.0);
    for (std::size_t each = 0; each < sizes.size(); ++each) {
      if (moves(each, k)) sizes[each] = find_size(each, k);
    }
    choose_idle_turns(k, sizes);
    const std::vector<double> change = change_of_forces(k, sizes);
    for (std::size_t i = 0; i < island_.size(); ++i) {
      most[own(i)] = larger(most[own(i)], norm(load(change.data(), i)));
      largest[own(i)] = larger(largest[own(i)], norm(load(before_.data(), i)));
    }
    std::size_t result = 0;
    for (std::size_t each = 0; each < sizes.size(); ++each) {
      if (moves(each, k) && most[each] <= digits * (largest[each] + stiffness_[each] * sizes[each])) ++result;
    }
    return result;
  }

  const EquilibriumEquations& equations_;
  const std::vector<double>& r_;
  const std::vector<int>& island_;
  const RigidFields& fields_;
  std::vector<RigidMotions>& motions_;  // [island]
  std::vector<double> before_;          // forces [3 points], N
  std::vector<double> stiffness_;       // [point] of its island, N/m
};

}  // namespace

std::vector<int> find_statics_islands(const EquilibriumEquations& equations) {
  const StiffnessMatrix& W = equations.stiffness();
  std::vector<int> parent(W.num_points());
  std::iota(parent.begin(), parent.end(), 0);
  const auto find = [&](int i) {
    while (parent[static_cast<std::size_t>(i)] != i) {
      int& up = parent[static_cast<std::size_t>(i)];
      i = up = parent[static_cast<std::size_t>(up)];
    }
    return i;
  };
  const auto join = [&](int i, int j) { parent[static_cast<std::size_t>(find(i))] = find(j); };
  for (std::size_t i = 0; i < W.num_points(); ++i) {
    for (int k = W.start()[i]; k < W.start()[i + 1]; ++k)
      join(static_cast<int>(i), W.columns()[static_cast<std::size_t>(k)]);
  }
  std::vector<int> first(equations.model().num_rows(), -1);
  for (const Incidence& incidence : equations.model().incidences) {
    if (static_cast<std::size_t>(incidence.point) >= parent.size()) continue;
    int& own = first[static_cast<std::size_t>(incidence.row)];
    own < 0 ? void(own = incidence.point) : join(own, incidence.point);
  }
  for (std::size_t i = 0; i < parent.size(); ++i) parent[i] = find(static_cast<int>(i));
  return parent;
}

std::vector<double> find_island_stiffness(const EquilibriumEquations& equations, const std::vector<int>& island) {
  const StiffnessMatrix& W = equations.stiffness();
  std::vector<double> largest(island.size(), 1e-150), result;
  for (std::size_t i = 0; i < island.size(); ++i) {
    double& own = largest[static_cast<std::size_t>(island[i])];
    own = std::max(own, W.largest_of(i));
  }
  for (const int own : island) result.push_back(largest[static_cast<std::size_t>(own)]);
  return result;
}

std::size_t count_rigid_modes(const EquilibriumEquations& equations, const std::vector<double>& r) {
  const std::vector<int> island = find_statics_islands(equations);
  const RigidFields fields(island, r.data());
  std::vector<RigidMotions> motions = AnswersToMotions(equations, island, fields).find_unanswered();
  return FiniteMotions(equations, r, island, fields, &motions).count_free();
}

}  // namespace tanor
