#include "statics/rigid_modes.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <optional>
#include <set>
#include <utility>
#include <variant>
#include <vector>

#include "base/dense.hpp"
#include "base/numbers.hpp"
#include "statics/islands.hpp"
#include "statics/steady_frame.hpp"

namespace tanor::detail {

namespace {

using Eigen::MatrixXd, Eigen::VectorXd;
using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Twist = Eigen::Vector<double, 6>;

/// Six motions of an island, shifts along the axes and turns about its centre, all of unit size, and combinations of
/// them by columns.
struct RigidIsland {
  Vec3 centre{};
  double radius = 0.0;  // largest distance of a point from the centre, m
  MatrixXd unanswered;  // moves of 1 m (root mean square) that nothing answers to
  MatrixXd idle;        // motions that move no point: turns about the line of all of them

  Vec3 shift(const Twist& c) const { return {c[0], c[1], c[2]}; }
  /// Returns the turn of a combination of motions, rad.
  Vec3 turn(const Twist& c) const { return (radius > 0.0 ? 1.0 / radius : 0.0) * Vec3{c[3], c[4], c[5]}; }
};

std::vector<RigidIsland> find_centres(const StaticsIslands& islands, const double* r) {
  std::vector<RigidIsland> result;
  for (const StaticsIsland& island : islands.list) {
    RigidIsland& own = result.emplace_back();
    for (const std::size_t i : island.points) own.centre = own.centre + load(r, i);
    own.centre = (1.0 / static_cast<double>(island.points.size())) * own.centre;
    for (const std::size_t i : island.points) own.radius = std::max(own.radius, norm(load(r, i) - own.centre));
  }
  return result;
}

/// Finds candidates only, up to what rounding may hide: squares lose small answers where a turn moves points little.
void find_candidates(const Matrix6& moves, const Matrix6& answers, double nothing, RigidIsland* island) {
  const dense::SymmetricEigen eigen = dense::find_eigen(moves);
  const Eigen::Index num_idle = (eigen.values.array() < 1e-10).count();
  const VectorXd squares = eigen.values.tail(6 - num_idle);
  const MatrixXd basis = eigen.vectors.rightCols(6 - num_idle) * squares.cwiseSqrt().cwiseInverse().asDiagonal();
  const dense::SymmetricEigen answer = dense::find_eigen(basis.transpose() * answers * basis);
  const double hidden = nothing / std::min(1.0, squares.minCoeff());
  island->unanswered = basis * answer.vectors.leftCols((answer.values.array() < hidden).count());
  island->idle = eigen.vectors.leftCols(num_idle);
}

/// Forces that nothing balances turn with an island where springs between its points exert them, as where their lengths
/// are known to a few digits: then W u = -turn x (f + K lambda). Loads stay as they are.
enum class NetForces { Stay, Turn };

/// Finds the motions u of each island that nothing answers to: W u, less what net forces that turn make of it, over the
/// island's stiffness, and K'u.
void find_unanswered(const EquilibriumEquations& equations, const StaticsIslands& all, const std::vector<double>& r,
                     NetForces net_forces, std::vector<RigidIsland>* islands) {
  constexpr double nothing = 1e-14;  // of squares
  const auto size = static_cast<Eigen::Index>(equations.size());
  MatrixXd U(size, 6), F(size, 6), R(static_cast<Eigen::Index>(equations.model().num_rows()), 6);
  for (Eigen::Index a = 0; a < 6; ++a) {
    const Twist c = Twist::Unit(a);
    for (std::size_t i = 0; i < all.of_point.size(); ++i) {
      const RigidIsland& own = (*islands)[all.of_point[i]];
      store(U.col(a).data(), i, own.shift(c) + cross(own.turn(c), load(r.data(), i) - own.centre));
    }
    equations.stiffness().multiply(U.col(a).data(), F.col(a).data());
    equations.apply_transposed(U.col(a).data(), R.col(a).data());
    for (std::size_t i = 0; net_forces == NetForces::Turn && i < all.of_point.size(); ++i)
      add_to(F.col(a).data(), i, cross((*islands)[all.of_point[i]].turn(c), equations.net_force(i)));
  }
  for (std::size_t k = 0; k < islands->size(); ++k) {
    const StaticsIsland& island = all.list[k];
    const std::vector<Eigen::Index> coordinates = island.coordinates();
    const auto count = static_cast<double>(island.points.size());
    const MatrixXd moves = U(coordinates, Eigen::all), forces = F(coordinates, Eigen::all) / island.stiffness,
                   rows = R(island.rows, Eigen::all);
    MatrixXd& found = (*islands)[k].unanswered;
    find_candidates(moves.transpose() * moves / count, forces.transpose() * forces + rows.transpose() * rows,
                    nothing * count, &(*islands)[k]);
    // Candidates are kept whose answers vanish when they are summed before they are squared.
    const VectorXd answered = (forces * found).colwise().squaredNorm() + (rows * found).colwise().squaredNorm();
    std::vector<Eigen::Index> kept;
    for (Eigen::Index column = 0; column < answered.size(); ++column) {
      if (answered[column] < nothing * count) kept.push_back(column);
    }
    found = found(Eigen::all, kept).eval();
  }
}

/// Finite motions of islands.
class FiniteMotions {
 public:
  FiniteMotions(const EquilibriumEquations& equations, const std::vector<double>& r, const StaticsIslands& all,
                std::vector<RigidIsland> islands)
      : equations_(equations),
        r_(r),
        all_(all),
        islands_(std::move(islands)),
        before_(evaluate(r)),
        gradients_(equations.model().num_rows(), 0.0),
        holds_(islands_.size()) {
    for (const Incidence& incidence : equations.model().incidences) {
      double& gradient = gradients_[static_cast<std::size_t>(incidence.row)];
      if (moves(incidence.point))
        gradient = std::hypot(gradient, norm(load(equations.gradients().data(), incidence.block)));
    }
    find_supports();
  }

  /// Counts the unanswered motions of the islands that leave their constraints as they are and their forces too, turned
  /// with them, over a finite distance, and that would leave the supports that hold them where they are: a link that
  /// turns about a point which others hold does not move as a whole. An infinitesimal motion is not enough: nothing
  /// answers to it at the top of -x^4, or where cranks turn. So that the count does not depend on the basis, sums of
  /// two motions are tried as well, and an island that does not follow all of them counts none. Nor does one that
  /// supports hold and no load acts on: it does not move as a free body does, and nothing tells one of its places from
  /// another.
  std::size_t count_free() {
    std::vector<char> is_free = find_loaded();
    for (std::size_t k = 0; k < is_free.size(); ++k) is_free[k] |= static_cast<char>(holds_[k].empty());
    for (Eigen::Index k = 0; k < 6; ++k) {
      for (Eigen::Index l = k; l < 6; ++l) find_held(k, l, &is_free);
    }
    (void)evaluate(r_);  // restores the forces that others may read
    std::size_t result = 0;
    for (std::size_t k = 0; k < islands_.size(); ++k)
      result += is_free[k] != 0 ? static_cast<std::size_t>(islands_[k].unanswered.cols()) : 0;
    return result;
  }

 private:
  /// A motion of one island and its size, m; 0 for an island that stays.
  struct Motion {
    Twist twist = Twist::Zero();
    double size = 0.0;
  };
  struct Values {
    std::vector<double> forces, rows;  // [3 points], N; [row]
  };

  bool moves(int point) const { return static_cast<std::size_t>(point) < all_.of_point.size(); }

  /// Lists the supports that constraints or forces join to each island.
  void find_supports() {
    std::vector<std::optional<std::size_t>> of_row(gradients_.size());
    for (std::size_t k = 0; k < islands_.size(); ++k) {
      for (const std::size_t row : all_.list[k].rows) of_row[row] = k;
    }
    for (const Incidence& incidence : equations_.model().incidences) {
      const auto& own = of_row[static_cast<std::size_t>(incidence.row)];
      if (own && !moves(incidence.point)) holds_[*own].insert(incidence.point);
    }
    const auto add_pair = [&](int point, int support) {
      if (moves(point) && !moves(support)) holds_[all_.of_point[static_cast<std::size_t>(point)]].insert(support);
    };
    for (const auto& [i, j] : equations_.work().forces.list_couplings()) add_pair(i, j), add_pair(j, i);
    for (const auto& [on, of] : equations_.work().forces.list_influences()) add_pair(on, of);
  }

  /// Marks the islands that feel a force from outside: weight, or one that acts on single points.
  std::vector<char> find_loaded() const {
    const Model& model = equations_.model();
    std::vector<char> result(islands_.size(), 0);
    const auto load_points = [&](const std::vector<Index>& points) {
      for (const Index point : points) {
        const auto i = static_cast<std::size_t>(model.numbering.inner_point[static_cast<std::size_t>(point)]);
        if (i < all_.of_point.size()) result[all_.of_point[i]] = 1;
      }
    };
    for (const Force& force : model.system.forces) {
      if (const auto* const gravity = std::get_if<Gravity>(&force); gravity && gravity->acceleration != Vector3{})
        std::ranges::fill(result, 1);
      if (const auto* const given = std::get_if<ConstantForce>(&force)) load_points(given->points);
      if (const auto* const formula = std::get_if<FormulaForce>(&force)) load_points(formula->points);
      if (const auto* const potential = std::get_if<Potential>(&force);
          potential && potential->kernel.num_points == 1) {
        for (const std::vector<Index>& tuple : potential->points) load_points(tuple);
      }
    }
    return result;
  }

  Values evaluate(const std::vector<double>& at) const {
    const Model& model = equations_.model();
    Values result{std::vector<double>(at.size(), 0.0), std::vector<double>(model.num_rows())};
    const std::vector<double> at_rest(at.size(), 0.0);
    equations_.work().forces.evaluate(model.parallel, equations_.time(), at.data(), at_rest.data(),
                                      result.forces.data());
    equations_.work().constraints.evaluate_values(model.parallel, at.data(), result.rows.data());
    return result;
  }

  /// Returns motion k, or the sum of motions k and l, of each island that has them, by a tenth of its radius or of a
  /// radian.
  std::vector<Motion> choose(Eigen::Index k, Eigen::Index l) const {
    constexpr double part = 0.1;
    std::vector<Motion> result;
    for (const RigidIsland& island : islands_) {
      Motion& own = result.emplace_back();
      if (l >= island.unanswered.cols()) continue;
      own.twist = island.unanswered.col(k);
      if (k != l) own.twist += island.unanswered.col(l);
      const double radius = std::max(island.radius, equations_.model().smallest_length);
      own.size = part * radius / std::max(1.0, own.twist.tail<3>().norm());
    }
    return result;
  }

  /// Returns the frame that carries an island along its motion for 1 s.
  SteadyFrame carrier(std::size_t island, const Motion& motion) const {
    const RigidIsland& own = islands_[island];
    return {.spin = motion.size * own.turn(motion.twist),
            .velocity = motion.size * own.shift(motion.twist),
            .centre = own.centre};
  }

  /// Returns what the motion of each island that moves changes: forces, less the earlier ones turned with it, over the
  /// largest force of the island and what its stiffness makes of the motion; and over the size of the motion distances
  /// from constraints, and the places of supports if they took part.
  std::vector<VectorXd> find_changes(const std::vector<Motion>& motions) const {
    std::vector<double> moved = r_;
    for (std::size_t k = 0; k < islands_.size(); ++k) {
      if (motions[k].size == 0.0) continue;
      const SteadyFrame frame = carrier(k, motions[k]);
      for (const std::size_t i : all_.list[k].points) store(moved.data(), i, frame.carry(load(r_.data(), i), 1.0));
    }
    const Values now = evaluate(moved);
    std::vector<VectorXd> result(islands_.size());
    for (std::size_t k = 0; k < islands_.size(); ++k) {
      if (motions[k].size > 0.0)
        result[k] = find_change(all_.list[k], motions[k], carrier(k, motions[k]), now, holds_[k]);
    }
    return result;
  }

  VectorXd find_change(const StaticsIsland& island, const Motion& motion, const SteadyFrame& frame, const Values& now,
                       const std::set<int>& supports) const {
    std::vector<double> result;
    const auto add = [&](double factor, Vec3 a) {
      result.insert(result.end(), {factor * a.x, factor * a.y, factor * a.z});
    };
    double largest = 0.0;
    for (const std::size_t i : island.points) largest = larger(largest, norm(load(before_.forces.data(), i)));
    const SteadyFrame turn{.spin = frame.spin};
    for (const std::size_t i : island.points)
      add(1.0 / (largest + island.stiffness * motion.size),
          load(now.forces.data(), i) - turn.carry(load(before_.forces.data(), i), 1.0));
    for (const std::size_t row : island.rows) {
      if (gradients_[row] > 0.0)
        result.push_back((now.rows[row] - before_.rows[row]) / (gradients_[row] * motion.size));
    }
    for (const int support : supports) {
      const Vec3 place = load(r_.data(), support);
      add(1.0 / motion.size, frame.carry(place, 1.0) - place);
    }
    return Eigen::Map<VectorXd>(result.data(), static_cast<Eigen::Index>(result.size()));
  }

  /// Adds a turn about the line of all points of an island. It moves no point at first order, but it decides about
  /// which axis they go on and where forces turn to. The Gauss-Newton method chooses the amount that changes least.
  void choose_idle_turns(std::vector<Motion>* motions) const {
    constexpr int steps = 8;
    constexpr double small = 1e-4;
    const auto turns = [&](std::size_t k) { return (*motions)[k].size > 0.0 && islands_[k].idle.cols() == 1; };
    const auto turn = [&](std::size_t k, double by) { (*motions)[k].twist += by * islands_[k].idle.col(0); };
    std::vector<std::size_t> turning;
    for (std::size_t k = 0; k < islands_.size(); ++k) {
      if (turns(k)) turning.push_back(k);
    }
    for (int step = 0; !turning.empty() && step < steps; ++step) {
      const std::vector<VectorXd> here = find_changes(*motions);
      for (const std::size_t k : turning) turn(k, small);
      const std::vector<VectorXd> there = find_changes(*motions);
      for (const std::size_t k : turning) {
        const VectorXd slope = (there[k] - here[k]) / small;
        const double slope2 = slope.squaredNorm();
        turn(k, -small - (slope2 > 0.0 ? slope.dot(here[k]) / slope2 : 0.0));
      }
    }
  }

  /// Marks the islands whose forces or constraints answer to motion k, or to the sum of motions k and l.
  void find_held(Eigen::Index k, Eigen::Index l, std::vector<char>* is_free) const {
    constexpr double digits = 1e-7;
    std::vector<Motion> motions = choose(k, l);
    if (std::ranges::all_of(motions, [](const Motion& each) { return each.size == 0.0; })) return;
    choose_idle_turns(&motions);
    const std::vector<VectorXd> changes = find_changes(motions);
    for (std::size_t own = 0; own < islands_.size(); ++own) {
      const double size = motions[own].size, places = 64.0 * eps * norm(islands_[own].centre);
      if (!(size * changes[own].array().abs() <= digits * size + places).all()) (*is_free)[own] = 0;
    }
  }

  const EquilibriumEquations& equations_;
  const std::vector<double>& r_;
  const StaticsIslands& all_;
  std::vector<RigidIsland> islands_;
  Values before_;
  std::vector<double> gradients_;     // [row]
  std::vector<std::set<int>> holds_;  // [island] supports that constraints or forces join to it
};

}  // namespace

std::size_t count_rigid_modes(const EquilibriumEquations& equations, const std::vector<double>& r) {
  const StaticsIslands all(equations);
  std::vector<RigidIsland> islands = find_centres(all, r.data()), turning = islands;
  find_unanswered(equations, all, r, NetForces::Stay, &islands);
  find_unanswered(equations, all, r, NetForces::Turn, &turning);
  for (std::size_t k = 0; k < islands.size(); ++k) {
    if (turning[k].unanswered.cols() > islands[k].unanswered.cols()) islands[k] = std::move(turning[k]);
  }
  return FiniteMotions(equations, r, all, std::move(islands)).count_free();
}

}  // namespace tanor::detail
