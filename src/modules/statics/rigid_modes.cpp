#include "statics/rigid_modes.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>
#include <variant>

#include "base/dense.hpp"
#include "base/numbers.hpp"
#include "statics/islands.hpp"

namespace tanor::detail {

namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;

/// Six motions of every island at once: shifts along the axes, and turns about its centre, all of unit size.
struct RigidFields {
  RigidFields(const std::vector<int>& island, const double* r);
  /// Returns the turn of motion `a` of an island, rad.
  Vec3 turn(std::size_t a, std::size_t of_island) const {
    const double size = radius[of_island] > 0.0 ? 1.0 / radius[of_island] : 0.0;
    return {a == 3 ? size : 0.0, a == 4 ? size : 0.0, a == 5 ? size : 0.0};
  }

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
      store(moves[k].data(), i, k < 3 ? axes[k] : cross(turn(k, own(i)), arm(i)));
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

/// Forces that nothing balances turn with an island where springs between its points exert them, as where their lengths
/// are known to a few digits: then W u = -turn x (f + K lambda). Loads stay as they are.
enum class NetForces { Stay, Turn };

/// The answers to small motions u of islands: W u, less what net forces that turn make of it, over the island's
/// stiffness, and K'u.
class AnswersToMotions {
 public:
  AnswersToMotions(const EquilibriumEquations& equations, const std::vector<int>& island, const RigidFields& fields,
                   NetForces net_forces)
      : island_(island), fields_(fields), of_row_(equations.model().num_rows(), -1) {
    const std::size_t n = island.size();
    const std::vector<double> stiffness = find_island_stiffness(equations, island);
    for (std::size_t a = 0; a < 6; ++a) {
      forces_[a].resize(3 * n);
      rows_[a].resize(of_row_.size());
      equations.stiffness().multiply(fields.moves[a].data(), forces_[a].data());
      equations.apply_transposed(fields.moves[a].data(), rows_[a].data());
      for (std::size_t i = 0; i < n; ++i) {
        const Vec3 turn = net_forces == NetForces::Turn ? fields.turn(a, static_cast<std::size_t>(island[i])) : Vec3{};
        const Vec3 answer = load(forces_[a].data(), i) + cross(turn, equations.net_force(i));
        store(forces_[a].data(), i, (1.0 / stiffness[i]) * answer);
      }
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
                const RigidFields& fields, std::vector<RigidMotions> motions)
      : equations_(equations),
        r_(r),
        island_(island),
        fields_(fields),
        motions_(std::move(motions)),
        before_(evaluate(r)),
        stiffness_(find_island_stiffness(equations, island)),
        gradients_(equations.model().num_rows(), 0.0),
        of_row_(equations.model().num_rows(), -1) {
    const auto moves = [&](int point) { return static_cast<std::size_t>(point) < island.size(); };
    for (const Incidence& incidence : equations.model().incidences) {
      if (!moves(incidence.point)) continue;
      const auto row = static_cast<std::size_t>(incidence.row);
      gradients_[row] = std::hypot(gradients_[row], norm(load(equations.gradients().data(), incidence.block)));
      of_row_[row] = island[static_cast<std::size_t>(incidence.point)];
    }
    const auto add = [&](int each, int support) {
      if (each >= 0 && !moves(support)) holds_.push_back({each, support});
    };
    for (const Incidence& incidence : equations.model().incidences)
      add(of_row_[static_cast<std::size_t>(incidence.row)], incidence.point);
    const auto add_pair = [&](int point, int support) {
      if (moves(point)) add(island[static_cast<std::size_t>(point)], support);
    };
    for (const auto& [i, j] : equations.work().forces.list_couplings()) add_pair(i, j), add_pair(j, i);
    for (const auto& [on, of] : equations.work().forces.list_influences()) add_pair(on, of);
    std::ranges::sort(holds_);
    holds_.erase(std::unique(holds_.begin(), holds_.end()), holds_.end());
    find_mechanisms();
  }

  /// Counts the unanswered motions of the islands that leave their constraints as they are and their forces too, turned
  /// with them, over a finite distance, and that would leave the supports that hold them where they are: a link that
  /// turns about a point which others hold does not move as a whole. An infinitesimal motion is not enough: nothing
  /// answers to it at the top of -x^4, or where cranks turn. So that the count does not depend on the basis, sums of
  /// two motions are tried as well, and an island that does not follow all of them counts none. Nor does one that
  /// supports hold and no load acts on: it does not move as a free body does, and nothing tells one of its places from
  /// another.
  std::size_t count_free() {
    std::vector<char> is_free(island_.size(), 1);
    for (const int each : mechanisms_) is_free[static_cast<std::size_t>(each)] = 0;
    for (Eigen::Index k = 0; k < 6; ++k) {
      for (Eigen::Index l = k; l < 6; ++l) find_held(k, l, &is_free);
    }
    (void)evaluate(r_);  // restores the forces that others may read
    std::size_t result = 0;
    for (std::size_t each = 0; each < motions_.size(); ++each)
      result += is_free[each] != 0 ? static_cast<std::size_t>(motions_[each].unanswered.cols()) : 0;
    return result;
  }

 private:
  using Twist = Eigen::Vector<double, 6>;
  /// One motion of each island, and its size, m; 0 for islands that stay.
  struct Motion {
    std::vector<Twist> twists;
    std::vector<double> sizes;
  };
  struct Values {
    std::vector<double> forces, rows;  // [3 points], N; [row]
    std::vector<double> supports{};    // [3 holds_], moves
  };

  std::size_t own(std::size_t i) const { return static_cast<std::size_t>(island_[i]); }

  /// Finds the islands that supports hold and that feel no force from outside: no weight, and none that acts on single
  /// points.
  void find_mechanisms() {
    const Model& model = equations_.model();
    std::vector<char> is_loaded(island_.size(), 0);
    const auto load_points = [&](const std::vector<Index>& points) {
      for (const Index point : points) {
        const auto i = static_cast<std::size_t>(model.numbering.inner_point[static_cast<std::size_t>(point)]);
        if (i < island_.size()) is_loaded[own(i)] = 1;
      }
    };
    for (const Force& force : model.system.forces) {
      if (const auto* const gravity = std::get_if<Gravity>(&force); gravity && gravity->acceleration != Vector3{})
        is_loaded.assign(island_.size(), 1);
      if (const auto* const given = std::get_if<ConstantForce>(&force)) load_points(given->points);
      if (const auto* const formula = std::get_if<FormulaForce>(&force)) load_points(formula->points);
      if (const auto* const potential = std::get_if<Potential>(&force);
          potential && potential->kernel.num_points == 1) {
        for (const std::vector<Index>& tuple : potential->points) load_points(tuple);
      }
    }
    for (const auto& [each, support] : holds_) {
      if (is_loaded[static_cast<std::size_t>(each)] == 0) mechanisms_.push_back(each);
    }
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
  Motion choose(Eigen::Index k, Eigen::Index l) const {
    constexpr double part = 0.1;
    Motion result{std::vector<Twist>(island_.size(), Twist::Zero()), std::vector<double>(island_.size(), 0.0)};
    for (std::size_t each = 0; each < island_.size(); ++each) {
      const Eigen::MatrixXd& columns = motions_[each].unanswered;
      if (l >= columns.cols()) continue;
      result.twists[each] = columns.col(k);
      if (k != l) result.twists[each] += columns.col(l);
      const double radius = std::max(fields_.radius[each], equations_.model().smallest_length);
      result.sizes[each] = part * radius / std::max(1.0, result.twists[each].tail<3>().norm());
    }
    return result;
  }

  /// Returns what a motion changes: forces, less the earlier ones turned with their island, over the largest force of
  /// the island and what its stiffness makes of the motion; and over the size of the motion distances from constraints,
  /// and the places of supports if they took part.
  Values find_change(const Motion& motion) const {
    std::vector<std::optional<Screw>> screws(island_.size());
    for (std::size_t each = 0; each < island_.size(); ++each) {
      if (motion.sizes[each] == 0.0) continue;
      const Twist& c = motion.twists[each];
      const double size = motion.sizes[each], radius = fields_.radius[each], turn = radius > 0.0 ? size / radius : 0.0;
      screws[each].emplace(size * Vec3{c[0], c[1], c[2]}, turn * Vec3{c[3], c[4], c[5]});
    }
    std::vector<double> moved = r_, largest(island_.size(), 0.0);
    for (std::size_t i = 0; i < island_.size(); ++i) {
      const Vec3 centre = fields_.centre[own(i)];
      if (const auto& screw = screws[own(i)])
        store(moved.data(), i, centre + screw->carry(load(r_.data(), i) - centre));
      largest[own(i)] = larger(largest[own(i)], norm(load(before_.forces.data(), i)));
    }
    Values change = evaluate(moved);
    for (std::size_t i = 0; i < island_.size(); ++i) {
      const auto& screw = screws[own(i)];
      const double scale = largest[own(i)] + stiffness_[i] * motion.sizes[own(i)];
      const Vec3 changed =
          screw ? load(change.forces.data(), i) - screw->rotate(load(before_.forces.data(), i)) : Vec3{};
      store(change.forces.data(), i, (1.0 / scale) * changed);
    }
    for (std::size_t row = 0; row < of_row_.size(); ++row) {
      const double size = of_row_[row] < 0 ? 0.0 : motion.sizes[static_cast<std::size_t>(of_row_[row])];
      const bool is_known = size > 0.0 && gradients_[row] > 0.0;
      change.rows[row] = is_known ? (change.rows[row] - before_.rows[row]) / (gradients_[row] * size) : 0.0;
    }
    for (const auto& [each, support] : holds_) {
      const auto& screw = screws[static_cast<std::size_t>(each)];
      const Vec3 arm = load(r_.data(), support) - fields_.centre[static_cast<std::size_t>(each)],
                 moves =
                     screw ? (1.0 / motion.sizes[static_cast<std::size_t>(each)]) * (screw->carry(arm) - arm) : Vec3{};
      change.supports.insert(change.supports.end(), {moves.x, moves.y, moves.z});
    }
    return change;
  }

  /// Calls visit(island, number) for all numbers of a change.
  template <class Visit>
  void for_each(const Values& change, const Visit& visit) const {
    for (std::size_t i = 0; i < 3 * island_.size(); ++i) visit(own(i / 3), change.forces[i]);
    for (std::size_t row = 0; row < of_row_.size(); ++row) {
      if (of_row_[row] >= 0) visit(static_cast<std::size_t>(of_row_[row]), change.rows[row]);
    }
    for (std::size_t k = 0; k < change.supports.size(); ++k)
      visit(static_cast<std::size_t>(holds_[k / 3].first), change.supports[k]);
  }

  /// Adds a turn about the line of all points of an island. It moves no point at first order, but it decides about
  /// which axis they go on and where forces turn to. The Gauss-Newton method chooses the amount that changes least.
  void choose_idle_turns(Motion* motion) const {
    constexpr int steps = 8;
    constexpr double small = 1e-4;
    const auto turns = [&](std::size_t each) { return motion->sizes[each] > 0.0 && motions_[each].idle.cols() == 1; };
    const auto turn = [&](const std::vector<double>& by) {
      for (std::size_t each = 0; each < by.size(); ++each) {
        if (turns(each)) motion->twists[each] += by[each] * motions_[each].idle.col(0);
      }
    };
    bool any = false;
    for (std::size_t each = 0; each < island_.size(); ++each) any = any || turns(each);
    for (int step = 0; any && step < steps; ++step) {
      std::vector<double> here;
      for_each(find_change(*motion), [&](std::size_t, double value) { here.push_back(value); });
      turn(std::vector<double>(island_.size(), small));
      std::vector<double> slope2(island_.size(), 0.0), along(island_.size(), 0.0), by(island_.size(), -small);
      std::size_t next = 0;
      for_each(find_change(*motion), [&](std::size_t each, double value) {
        const double slope = (value - here[next]) / small;
        slope2[each] += slope * slope;
        along[each] += slope * here[next++];
      });
      for (std::size_t each = 0; each < by.size(); ++each) {
        if (slope2[each] > 0.0) by[each] -= along[each] / slope2[each];
      }
      turn(by);
    }
  }

  /// Marks the islands whose forces or constraints answer to motion k, or to the sum of motions k and l.
  void find_held(Eigen::Index k, Eigen::Index l, std::vector<char>* is_free) const {
    constexpr double digits = 1e-7;
    Motion motion = choose(k, l);
    if (std::ranges::all_of(motion.sizes, [](double size) { return size == 0.0; })) return;
    choose_idle_turns(&motion);
    for_each(find_change(motion), [&](std::size_t each, double value) {
      const double size = motion.sizes[each], places = 64.0 * eps * norm(fields_.centre[each]);
      if (size > 0.0 && !(size * std::abs(value) <= digits * size + places)) (*is_free)[each] = 0;
    });
  }

  const EquilibriumEquations& equations_;
  const std::vector<double>& r_;
  const std::vector<int>& island_;
  const RigidFields& fields_;
  std::vector<RigidMotions> motions_;  // [island]
  Values before_;
  std::vector<double> stiffness_;           // [point] of its island, N/m
  std::vector<double> gradients_;           // [row]
  std::vector<int> of_row_;                 // [row] its island, -1: it joins no moving points
  std::vector<std::pair<int, int>> holds_;  // an island, and a support that constraints or forces join to it
  std::vector<int> mechanisms_;             // islands that count no motions
};

}  // namespace

std::size_t count_rigid_modes(const EquilibriumEquations& equations, const std::vector<double>& r) {
  const std::vector<int> island = find_statics_islands(equations);
  const RigidFields fields(island, r.data());
  std::vector<RigidMotions> motions = AnswersToMotions(equations, island, fields, NetForces::Stay).find_unanswered(),
                            turning = AnswersToMotions(equations, island, fields, NetForces::Turn).find_unanswered();
  for (std::size_t each = 0; each < motions.size(); ++each) {
    if (turning[each].unanswered.cols() > motions[each].unanswered.cols()) motions[each] = std::move(turning[each]);
  }
  return FiniteMotions(equations, r, island, fields, std::move(motions)).count_free();
}

}  // namespace tanor::detail
