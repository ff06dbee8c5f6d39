/// Measures how right accelerations and multipliers are, against the same equations in quadruple precision.
///
///   digits [NAME …]   scenes whose name begins so; default: all
///
/// The scenes are those of bench_scenes.cpp and of tests/motion/extreme_scenes.hpp as they start, and a net, a tree and
/// clusters with masses of 1 to 1e12 kg. K, phi and S come from the definitions of the kinds in numbers of 113 bits and
/// Eigen's LDL' solves them; of forces other than gravity the library's own accelerations are taken. Prints the largest
/// |w - w*| over the largest |w*| or |M^-1 f|, and |lambda - lambda*| over the largest |lambda*|, a line a scene; "-"
/// where rows of K depend on each other, so that only w is unique, or where nothing is constrained. The last lines have
/// the median and the largest of each.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <random>
#include <string>
#include <variant>
#include <vector>

#include <Eigen/SparseCholesky>
#include <tanor/dynamics.hpp>

#include "bench_scenes.hpp"
#include "motion/extreme_scenes.hpp"
#include "quadruple.hpp"

namespace {

using namespace tanor;

struct Problem {
  std::string name;
  System system;
};

/// The equations (31), (23), (25) at the positions and velocities of a system.
class Reference {
 public:
  explicit Reference(const System& system) : system_(system), inverse_mass_(system.masses.size()) {
    for (std::size_t i = 0; i < inverse_mass_.size(); ++i) inverse_mass_[i] = Quad(1.0) / system.masses[i];
    for (const Support& support : system.supports) {
      for (const Index point : support.points) inverse_mass_[static_cast<std::size_t>(point)] = 0.0;
    }
    set_free_accelerations();
    for (const Quad number : w_) largest_free_ = std::max(largest_free_, abs(number));
    for (const Constraint& constraint : system.constraints)
      std::visit([&](const auto& group) { add(group); }, constraint);
    solve();
  }

  const std::vector<Quad>& w() const { return w_; }
  Quad largest_free() const { return largest_free_; }
  const std::vector<Quad>& lambda() const { return lambda_; }
  bool has_independent_rows() const { return has_independent_rows_; }

 private:
  struct Block {
    int row;
    std::size_t point;
    std::array<Quad, 3> gradient;
  };

  /// w0 = M^-1 f: gravity to all digits, other forces as the library has them.
  void set_free_accelerations() {
    System free = system_;
    free.constraints.clear();
    std::erase_if(free.forces, [](const Force& force) { return std::holds_alternative<Gravity>(force); });
    std::vector<double> others(system_.positions.size(), 0.0);
    if (!free.forces.empty()) {
      Dynamics dynamics(free, {.threads = 1});
      const std::vector<double> v = velocities();
      (void)dynamics.solve({.time = 0.0, .positions = system_.positions, .velocities = v}, {.accelerations = others});
    }
    w_.assign(others.begin(), others.end());
    for (const Force& force : system_.forces) {
      const auto* gravity = std::get_if<Gravity>(&force);
      for (std::size_t i = 0; gravity != nullptr && i < inverse_mass_.size(); ++i) {
        for (std::size_t c = 0; c < 3 && inverse_mass_[i] > 0.0; ++c) w_[3 * i + c] += gravity->acceleration[c];
      }
    }
  }
  std::vector<double> velocities() const {
    return system_.velocities.empty() ? std::vector<double>(system_.positions.size(), 0.0) : system_.velocities;
  }

  /// Evaluates phi along r + e v, and each gradient along one number.
  template <class Group>
  void add(const Group& group) {
    using Kind = KindOf<Group>;
    if constexpr (std::is_same_v<Group, Rods> || std::is_same_v<Group, Planes> || std::is_same_v<Group, Spheres> ||
                  std::is_same_v<Group, Circles>) {
      const typename Kind::template Definition<QuadJet> definition(group, ClockOf<QuadJet>{0.0});
      const std::vector<double> v = velocities();
      const auto& members = group.*Kind::members;
      for (std::size_t k = 0; k < members.size(); ++k) {
        const std::vector<std::size_t> points = list_points(members[k]);
        const auto evaluate = [&](auto rate) {
          std::vector<TripleOf<QuadJet>> r;
          for (std::size_t p = 0; p < points.size(); ++p) {
            const auto number = [&](std::size_t c) {
              return QuadJet(Quad(system_.positions[3 * points[p] + c]), rate(p, c));
            };
            r.push_back({number(0), number(1), number(2)});
          }
          return definition.xi(r, QuadJet(), k);
        };
        const auto moving = evaluate([&](std::size_t p, std::size_t c) { return Quad(v[3 * points[p] + c]); });
        for (const QuadJet& xi : moving) phi_.push_back(2.0 * xi.c[2]);
        for (std::size_t p = 0; p < points.size(); ++p) {
          std::array<std::array<Quad, 3>, Kind::rows> gradients{};
          for (std::size_t c = 0; c < 3; ++c) {
            const auto along =
                evaluate([&](std::size_t q, std::size_t d) { return Quad(p == q && c == d ? 1.0 : 0.0); });
            for (std::size_t row = 0; row < gradients.size(); ++row) gradients[row][c] = along[row].c[1];
          }
          for (std::size_t row = 0; row < gradients.size(); ++row)
            blocks_.push_back({num_rows_ + static_cast<int>(row), points[p], gradients[row]});
        }
        num_rows_ += Kind::rows;
      }
    } else {
      throw std::runtime_error("no reference for " + std::string(Kind::name));
    }
  }
  static std::vector<std::size_t> list_points(Index point) { return {static_cast<std::size_t>(point)}; }
  static std::vector<std::size_t> list_points(const std::array<Index, 2>& pair) {
    return {static_cast<std::size_t>(pair[0]), static_cast<std::size_t>(pair[1])};
  }

  void solve() {
    std::vector<Eigen::Triplet<Quad>> entries;
    Eigen::Matrix<Quad, Eigen::Dynamic, 1> b(num_rows_);
    for (int row = 0; row < num_rows_; ++row) b[row] = -phi_[static_cast<std::size_t>(row)];
    std::vector<std::vector<const Block*>> of_point(inverse_mass_.size());
    for (const Block& block : blocks_) {
      of_point[block.point].push_back(&block);
      for (std::size_t c = 0; c < 3; ++c) b[block.row] -= block.gradient[c] * w_[3 * block.point + c];
    }
    for (std::size_t i = 0; i < of_point.size(); ++i) {
      for (const Block* one : of_point[i]) {
        for (const Block* other : of_point[i]) {
          if (one->row < other->row) continue;
          Quad product;
          for (std::size_t c = 0; c < 3; ++c) product += one->gradient[c] * other->gradient[c];
          entries.emplace_back(one->row, other->row, inverse_mass_[i] * product);
        }
      }
    }
    Eigen::SparseMatrix<Quad> S(num_rows_, num_rows_);
    S.setFromTriplets(entries.begin(), entries.end());
    Eigen::SimplicialLDLT<Eigen::SparseMatrix<Quad>> factor(S);
    constexpr double rounding = 1e-22;
    const auto pivots = factor.vectorD();
    const Eigen::Matrix<Quad, Eigen::Dynamic, 1> diagonal = factor.permutationP() * S.diagonal().eval();
    for (int row = 0; row < num_rows_; ++row)
      has_independent_rows_ = has_independent_rows_ && pivots[row] > rounding * diagonal[row];
    if (!has_independent_rows_) return;
    const Eigen::Matrix<Quad, Eigen::Dynamic, 1> x = factor.solve(b);
    lambda_.assign(x.data(), x.data() + num_rows_);
    for (const Block& block : blocks_) {
      for (std::size_t c = 0; c < 3; ++c)
        w_[3 * block.point + c] += inverse_mass_[block.point] * block.gradient[c] * x[block.row];
    }
  }

  const System& system_;
  std::vector<Quad> inverse_mass_, phi_, w_, lambda_;
  std::vector<Block> blocks_;
  Quad largest_free_;
  int num_rows_ = 0;
  bool has_independent_rows_ = true;
};

/// Returns the largest difference over the largest number, or over `largest` if that is more.
double error_of(const std::vector<double>& found, const std::vector<Quad>& right, Quad largest = {}) {
  Quad difference;
  for (std::size_t i = 0; i < found.size(); ++i) {
    difference = std::max(difference, abs(found[i] - right[i]));
    largest = std::max(largest, abs(right[i]));
  }
  return largest > 0.0 ? static_cast<double>(difference / largest) : static_cast<double>(difference);
}

System with_masses_up_to(double ratio, System system) {
  std::mt19937 generator(12);
  std::uniform_real_distribution<double> exponent(0.0, std::log(ratio));
  for (double& mass : system.masses) mass = std::exp(exponent(generator));
  return system;
}

std::vector<Problem> list_problems(const std::vector<std::string>& wanted) {
  const auto is_wanted = [&](const std::string& name) {
    return wanted.empty() ||
           std::any_of(wanted.begin(), wanted.end(), [&](const auto& word) { return name.starts_with(word); });
  };
  std::vector<Problem> result;
  for (const BenchScene& scene : bench_scenes()) {
    if (is_wanted(scene.name)) result.push_back({scene.name, scene.make()});
    for (const double ratio : {1.0, 1e3, 1e6, 1e9, 1e12}) {
      const std::string name = fmt::format("{}, masses up to {:.0e}", scene.name, ratio);
      const bool has_masses =
          scene.name == "net 30" || scene.name == "random tree 1e3" || scene.name == "clusters 1e3 x 10";
      if (has_masses && is_wanted(name)) result.push_back({name, with_masses_up_to(ratio, scene.make())});
    }
  }
  for (const extreme::Case& scene : extreme::list_cases()) {
    const std::string name = "extreme: " + scene.name;
    if (is_wanted(name)) result.push_back({name, scene.system});
  }
  return result;
}

struct Errors {
  std::vector<double> of_w, of_lambda;
};

/// Prints the errors of one problem, and adds them to those of all.
void measure(const Problem& problem, Errors* errors) {
  const System& system = problem.system;
  Dynamics dynamics(system, {.threads = 1});
  std::vector<double> w(system.positions.size()), lambda(dynamics.num_equations());
  const std::vector<double> v = system.velocities.empty() ? std::vector<double>(w.size(), 0.0) : system.velocities;
  const auto report = dynamics.solve({.time = 0.0, .positions = system.positions, .velocities = v},
                                     {.accelerations = w, .multipliers = lambda});
  const auto text = [](double error) { return std::isnan(error) ? std::string("-") : fmt::format("{:.1e}", error); };
  double of_w = NAN, of_lambda = NAN;
  std::string why = report.outcome.ok() ? "" : report.outcome.what;
  if (report.outcome.ok()) {
    const Reference reference(system);
    if (!reference.has_independent_rows()) {
      why = "rows depend on each other";
    } else {
      errors->of_w.push_back(of_w = error_of(w, reference.w(), reference.largest_free()));
      if (!lambda.empty()) errors->of_lambda.push_back(of_lambda = error_of(lambda, reference.lambda()));
    }
  }
  fmt::print("{:60} {:>9} {:>9}  {}\n", problem.name, text(of_w), text(of_lambda), why);
  std::fflush(stdout);
}

}  // namespace

int main(int argc, char** argv) try {
  Errors errors;
  fmt::print("{:60} {:>9} {:>9}\n", "largest error over largest number", "w", "lambda");
  for (const Problem& problem : list_problems({argv + 1, argv + argc})) measure(problem, &errors);
  const auto sort = [](std::vector<double> each) {
    std::sort(each.begin(), each.end());
    return each;
  };
  const std::vector<double> w = sort(errors.of_w), lambda = sort(errors.of_lambda);
  if (w.empty() || lambda.empty()) return 0;
  fmt::print("{:60} {:9.1e} {:9.1e}\n{:60} {:9.1e} {:9.1e}\n", "median", w[w.size() / 2], lambda[lambda.size() / 2],
             "largest", w.back(), lambda.back());
} catch (const std::exception& error) {
  fmt::print(stderr, "digits: {}\n", error.what());
  return 1;
}
