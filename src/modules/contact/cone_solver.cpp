#include "contact/cone_solver.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <ctime>
#include <limits>
#include <memory>
#include <numeric>
#include <utility>

#include "contact/cone.hpp"
#include "contact/one_contact.hpp"
#include "factor/sparse_lu.hpp"

namespace tanor::detail {

namespace {

double processor_seconds() {
  return static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
}

double squared_norm(const std::vector<double>& a) {
  return std::inner_product(a.begin(), a.end(), a.begin(), 0.0);
}

/// Returns the problem with W over its scale and |q| = 1. Its error is |r - P(r - u)|.
ConeProblem scaled(ConeProblem problem, double of_W, double of_q) {
  for (Block3& block : problem.blocks)
    for (double& entry : block.entries) entry /= of_W;
  for (double& each : problem.q) each /= of_q;
  return problem;
}

/// Newton's matrix A + B (W + alpha I) with 3 x 3 blocks A and B, and its factor.
class NewtonMatrix {
 public:
  explicit NewtonMatrix(const ConeProblem& problem) : problem_(problem) {
    const std::size_t n = problem.num_contacts();
    std::vector<std::vector<std::pair<int, std::size_t>>> of_column(n);  // row, block
    for (std::size_t c = 0; c < n; ++c)
      for (std::size_t k = problem.start[c]; k < problem.start[c + 1]; ++k)
        of_column[static_cast<std::size_t>(problem.columns[k])].emplace_back(static_cast<int>(c), k);
    place_.resize(9 * problem.blocks.size());
    SquarePattern pattern;
    for (const auto& blocks : of_column) {
      for (int j = 0; j < 3; ++j) {
        for (const auto& [row, block] : blocks) {
          for (int i = 0; i < 3; ++i) {
            place_[9 * block + static_cast<std::size_t>(3 * i + j)] = pattern.rows.size();
            pattern.rows.push_back(3 * row + i);
          }
        }
        pattern.start.push_back(static_cast<int>(pattern.rows.size()));
      }
    }
    lu_ = std::make_unique<SparseLu<double>>(std::move(pattern));
  }

  /// Sets the rows of a contact.
  void set_rows(std::size_t contact, const Block3& A, const Block3& B, double alpha) {
    double* const values = lu_->values();
    for (std::size_t k = problem_.start[contact]; k < problem_.start[contact + 1]; ++k) {
      const Block3& W = problem_.blocks[k];
      const bool is_own = static_cast<std::size_t>(problem_.columns[k]) == contact;
      for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) {
          double sum = is_own ? A(i, j) + alpha * B(i, j) : 0.0;
          for (int l = 0; l < 3; ++l) sum += B(i, l) * W(l, j);
          values[place_[9 * k + static_cast<std::size_t>(3 * i + j)]] = sum;
        }
      }
    }
  }
  bool factorize() { return lu_->factorize(); }
  void solve(double* x) { lu_->solve(x); }

 private:
  const ConeProblem& problem_;
  std::vector<std::size_t> place_;  // [entry of blocks] in the values of the matrix
  std::unique_ptr<SparseLu<double>> lu_;
};

class ConeSolver {
 public:
  ConeSolver(ConeProblem problem, const ConeOptions& options, std::vector<double> r)
      : problem_(std::move(problem)), options_(options), r_(std::move(r)), best_(r_), begun_(processor_seconds()) {
    for (std::vector<double>* array : {&F_, &direction_, &trial_, &trial_F_, &anchor_}) array->resize(r_.size());
    rho_.resize(problem_.num_contacts());
    for (std::size_t c = 0; c < rho_.size(); ++c) {
      const Block3& own = problem_.own_block(c);
      rho_[c] = 3.0 / (own(0, 0) + own(1, 1) + own(2, 2));
    }
  }

  ConeReport solve() {
    note_error();
    sweep(options_.most_sweeps);
    if (!is_done()) step_towards_solution();
    report_.is_solved = report_.error <= options_.tolerance;
    return report_;
  }
  const std::vector<double>& best() const { return best_; }

 private:
  bool is_done() const {
    return report_.error <= options_.tolerance ||
           (options_.seconds > 0.0 && processor_seconds() - begun_ > options_.seconds);
  }

  bool has_factorized_enough() const { return report_.factorizations >= options_.most_factorizations; }

  /// Keeps r_ if its error is the smallest one so far. Returns the error.
  double note_error() {
    const double error = error_of_contacts(problem_, r_);
    if (error < report_.error || (report_.sweeps == 0 && report_.factorizations == 0)) {
      report_.error = error;
      best_ = r_;
    }
    return error;
  }

  // ---- sweeps ----

  void sweep(int most) {
    constexpr int sweeps_between_looks = 10;
    for (int k = 1; k <= most && !is_done(); ++k) {
      for (std::size_t c = 0; c < problem_.num_contacts(); ++c) {
        const Block3& own = problem_.own_block(c);
        const Vec3 before = load(r_.data(), c), rest = problem_.velocity(c, r_.data()) - own * before;
        store(r_.data(), c, solve_one_contact(own, rest, problem_.friction[c], before));
      }
      ++report_.sweeps;
      if (k % sweeps_between_looks == 0 || k == most) note_error();
    }
  }

  // ---- proximal points ----

  /// Goes from anchor to anchor. Where forces run in one direction, as along one that W nearly leaves free, the next
  /// anchor lies ahead by twice as many steps as the last time.
  void step_towards_solution() {
    constexpr double first_alpha = 1e-2, least_alpha = 1e-9, most_alpha = 1e3, change = 3.0, most_ahead = 16.0;
    constexpr int few_iterations = 10, sweeps_after_failure = 20;
    matrix_ = std::make_unique<NewtonMatrix>(problem_);
    double alpha = first_alpha, ahead = 0.0;
    std::vector<double> begin = best_, move(r_.size()), last_move(r_.size());
    r_ = best_;
    for (double before = report_.error; !is_done() && !has_factorized_enough(); begin = r_) {
      for (std::size_t i = 0; i < r_.size(); ++i) anchor_[i] = r_[i] += ahead * move[i];
      const int iterations = find_proximal_point(alpha, std::max(0.1 * options_.tolerance, 1e-2 * before));
      const double now = note_error();
      if (iterations >= 0 && (ahead == 0.0 || now < 2.0 * before)) {
        last_move.swap(move);
        for (std::size_t i = 0; i < r_.size(); ++i) move[i] = r_[i] - begin[i];
        const double along = std::inner_product(move.begin(), move.end(), last_move.begin(), 0.0);
        const bool runs_on = along > 0.8 * std::sqrt(squared_norm(move) * squared_norm(last_move));
        ahead = now > 0.5 * before && runs_on ? std::clamp(2.0 * ahead, 1.0, most_ahead) : 0.0;
        if (iterations <= few_iterations || (now > 0.9 * before && ahead == 0.0))
          alpha = std::max(least_alpha, alpha / change);
        before = now;
      } else {
        r_ = begin;
        if (std::exchange(ahead, 0.0) > 0.0) continue;
        alpha = std::min(most_alpha, change * alpha);
        sweep(sweeps_after_failure);
        before = error_of_contacts(problem_, r_);
      }
    }
  }

  /// Computes F = r - P(r - rho u) with u = W r + q + alpha (r - anchor). Returns |F|^2.
  double evaluate(const std::vector<double>& r, double alpha, std::vector<double>* F) const {
    for (std::size_t c = 0; c < rho_.size(); ++c) {
      const Vec3 own = load(r.data(), c), y = own - rho_[c] * with_dilatancy(proximal_velocity(r, alpha, c), mu(c));
      store(F->data(), c, own - project_onto_cone(y, mu(c)));
    }
    return squared_norm(*F);
  }
  Vec3 proximal_velocity(const std::vector<double>& r, double alpha, std::size_t c) const {
    return problem_.velocity(c, r.data()) + alpha * (load(r.data(), c) - load(anchor_.data(), c));
  }
  double mu(std::size_t contact) const { return problem_.friction[contact]; }

  /// Writes the rows of F' = (I - P') dr + rho P' (I + mu n u_t'/|u_t|) (W + alpha I) dr.
  void linearise(double alpha) {
    for (std::size_t c = 0; c < rho_.size(); ++c) {
      const Vec3 u = proximal_velocity(r_, alpha, c);
      const Block3 P = derive_projection(load(r_.data(), c) - rho_[c] * with_dilatancy(u, mu(c)), mu(c));
      Block3 A, B;
      const double t = tangential(u), y = t > 0.0 ? mu(c) * u.y / t : 0.0, z = t > 0.0 ? mu(c) * u.z / t : 0.0;
      A.add_identity(1.0);
      for (std::size_t i = 0; i < 3; ++i) {
        for (std::size_t j = 0; j < 3; ++j) A.entries[3 * i + j] -= P.entries[3 * i + j];
        const double normal = rho_[c] * P.entries[3 * i];
        B.entries[3 * i] = normal;
        B.entries[3 * i + 1] = rho_[c] * P.entries[3 * i + 1] + normal * y;
        B.entries[3 * i + 2] = rho_[c] * P.entries[3 * i + 2] + normal * z;
      }
      matrix_->set_rows(c, A, B, alpha);
    }
  }

  /// Finds F = 0 at the anchor from r_ on by Newton's method. Returns its iterations, or -1 if it does not converge.
  int find_proximal_point(double alpha, double target) {
    constexpr int most_iterations = 15, memory = 10;
    std::array<double, memory> merits;
    double merit = evaluate(r_, alpha, &F_);
    merits.fill(merit);
    for (int k = 0; k < most_iterations; ++k) {
      if (merit <= target * target || is_done() || has_factorized_enough()) return k;
      linearise(alpha);
      ++report_.factorizations;
      if (!matrix_->factorize()) return -1;
      for (std::size_t i = 0; i < F_.size(); ++i) direction_[i] = -F_[i];
      matrix_->solve(direction_.data());
      const double allowed = *std::max_element(merits.begin(), merits.end());
      constexpr double shortest = 1e-4, decrease = 1e-4;
      double length = 1.0, at = std::numeric_limits<double>::infinity();
      for (; length > shortest; length *= 0.5) {
        for (std::size_t i = 0; i < r_.size(); ++i) trial_[i] = r_[i] + length * direction_[i];
        at = evaluate(trial_, alpha, &trial_F_);
        if (at <= (1.0 - decrease * length) * allowed) break;
      }
      if (length <= shortest) return -1;
      r_.swap(trial_);
      F_.swap(trial_F_);
      merit = at;
      merits[static_cast<std::size_t>(k) % memory] = merit;
    }
    return -1;
  }

  const ConeProblem problem_;
  const ConeOptions options_;
  std::vector<double> r_, best_;
  double begun_;
  ConeReport report_;
  std::vector<double> F_, direction_, trial_, trial_F_, anchor_, rho_;
  std::unique_ptr<NewtonMatrix> matrix_;
};

}  // namespace

ConeReport solve_contacts(const ConeProblem& problem, const ConeOptions& options, std::vector<double>* r) {
  const double of_W = problem.scale(), of_q = std::sqrt(squared_norm(problem.q));
  if (!(of_q > 0.0)) {
    std::fill(r->begin(), r->end(), 0.0);
    return {.is_solved = true};
  }
  const double unit = of_q / of_W;
  for (double& each : *r) each /= unit;
  ConeSolver solver(scaled(problem, of_W, of_q), options, *r);
  const ConeReport report = solver.solve();
  *r = solver.best();
  for (double& each : *r) each *= unit;
  return report;
}

}  // namespace tanor::detail
