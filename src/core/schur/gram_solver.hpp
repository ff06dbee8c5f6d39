#pragma once

#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "assembly/gather_plan.hpp"
#include "base/parallel.hpp"
#include "factor/cholesky.hpp"
#include "plan/thresholds.hpp"
#include "schur/factor_summary.hpp"
#include "system/numbering.hpp"

namespace tanor::detail {

/// Islands of rows, which no product joins: the first row of each, then the number of rows that take part.
struct RowIslands {
  std::span<const Index> start;
  std::size_t num_rows;

  RowIslands(std::span<const Index> first_rows, std::size_t rows) : start(first_rows), num_rows(rows) {}
  RowIslands(const Numbering& numbering)  // NOLINT(google-explicit-constructor): the rows of K
      : start(numbering.island_start), num_rows(numbering.num_rows()) {}
};

/// Cuts the islands into at most 16 parts of similar size, of whole islands each. Parts are factorized and solved side
/// by side. The cut does not depend on the number of threads, so neither do the results. `island_start` holds the first
/// row of each island, then d. Returns the first row of each part, then d.
std::vector<Index> partition_islands(std::span<const Index> island_start);

/// Returns true if a part should be worked on by all threads, before the others are shared among them: it would keep
/// the others waiting, and threads of its own make it faster. `cost` is in the unit of `all`, that of all parts.
inline bool runs_alone(double cost, double all, int threads, bool gains_by_threads) {
  return gains_by_threads && threads * cost > all;
}

/// Solves X'WX x = b for a basis X in blocks and diagonal weights W. S = K'M^-1K, Gamma = K'K, H = A'MA and G = A'A are
/// the paper's four such matrices. The solver works part by part (Cholesky); a part is a group of islands.
class GramSolver {
 public:
  /// Takes the incidences of all points and the weights [point], which are 0 for points that take no part (supports).
  /// `squared_norms` [block] is as GatherPlan takes it. The order of elimination may follow from `places`.
  GramSolver(std::span<const Incidence> incidences, std::span<const double> weights, const RowIslands& rows,
             Ordering ordering, std::span<const double> squared_norms, const PointPlaces& places = {},
             LinearSolver wanted = LinearSolver::General);
  /// Takes the products themselves, sorted by the islands of their rows.
  GramSolver(std::span<const Product> products, const RowIslands& rows, Ordering ordering,
             LinearSolver wanted = LinearSolver::General);

  using Quality = Cholesky::Quality;  ///< that of the worst part, with an inner row
  /// Below this the scaled matrix counts as singular, since CHOLMOD may accept an exactly singular matrix (measured).
  static constexpr double singular_below = 3e-14;

  /// Sets the rows [row] that take part from the next `assemble` on, all of them if `active` is empty. An inactive row
  /// becomes a unit row of the same pattern, and its x is 0.
  void set_active(std::span<const char> active);

  /// Allows rows that come and go to have gradient 0; they then become unit rows.
  void allow_zero_rows(const Numbering& numbering);

  /// Sets the scaled diagonal of those rows, where they take part, to 1 + compliance from the next `assemble` on. The
  /// rows may then depend on others: refined solutions of consistent equations still satisfy S x = b, with the least x
  /// in these rows. `weights` [row from `first` on] multiply the compliance; they are 1 if empty.
  void set_compliance(double compliance, std::vector<double> weights = {}) {
    compliance_ = compliance;
    compliance_weights_ = std::move(weights);
  }

  void assemble(const Parallel& parallel, const double* blocks);
  [[nodiscard]] Quality factorize(const Parallel& parallel);
  /// Estimates 1/cond of the scaled matrix by a few inverse iterations with the last factor, for certificates. It is
  /// closer than the estimate of `factorize`, which is a cheap bound from above.
  double estimate_reciprocal_condition();
  /// Returns the rows [first, end) of each part that was found singular, or worse than `reciprocal_condition`.
  std::vector<std::pair<Index, Index>> weak_parts(double reciprocal_condition) const;

  /// Computes x = -(X'WX)^-1 b, the sign that (31) and every projection want. x may be b. Idle rows get 0.
  void solve_negative(const Parallel& parallel, const double* b, double* x);

  struct Summary {
    FactorSummary factor;
    /// The multiplications, done one by one, that take as long as assembly, factorization and a solve.
    double products = 0.0;
  };
  const Summary& summary() const { return summary_; }
  /// Returns the numbers of the scaled matrices that were assembled last, part by part, for tests that corrupt them.
  std::vector<std::span<double>> assembled() {
    std::vector<std::span<double>> numbers;
    for (Part& part : parts_) numbers.emplace_back(part.factor.values(), part.plan.rows().size());
    return numbers;
  }

 private:
  struct Part {
    Index first_row;
    std::vector<int> permutation;  // [place] -> row of the part; empty if the order stays
    GatherPlan plan;
    Cholesky factor;
    std::vector<double> x;  // right-hand side in the order of elimination
    double products;        // as in Summary
    Quality quality{};
    std::vector<std::pair<std::size_t, double>> fixed_slots{};  // slots of rows that take no part, with their values
    std::vector<std::size_t> inactive_places{};                 // of these rows
    struct MayBeZero {
      std::size_t slot;                    // on the diagonal
      std::optional<std::size_t> contact;  // number of its row among those of contacts
    };
    std::vector<MayBeZero> may_be_zero{};

    /// Returns the row at a place in the order of elimination.
    std::size_t row_at(std::size_t place) const {
      return static_cast<std::size_t>(first_row) +
             (place < permutation.size() ? static_cast<std::size_t>(permutation[place]) : place);
    }
    /// Calls visit(row, column, slot) for each number of the factor's triangle.
    template <class Visit>
    void for_slots(const Visit& visit) const;
    bool assembles_by_threads() const { return plan.rows().size() >= 2 * detail::plan::products_worth_a_thread; }
    bool factorizes_by_threads() const { return factor.factorizes_by_threads(); }
    bool solves_by_threads() const { return factor.solves_by_threads(); }
  };

  GramSolver(const RowIslands& rows, LinearSolver wanted);
  void add_part(std::span<const Product> products, Index first_row, Index end_row, Ordering wanted,
                std::span<const double> squared_norms, const FindPoints& find_points);

  /// Calls body(part, threads). Parts that would keep the others waiting and that threads of their own make faster, see
  /// gains_by_threads(part), come one after the other with all threads, the rest side by side.
  template <class Gains, class Body>
  void for_parts(const Parallel& parallel, const Gains& gains_by_threads, const Body& body) {
    const auto is_alone = [&](const Part& part) {
      return parts_.size() == 1 ||
             runs_alone(part.products, summary_.products, parallel.threads(), gains_by_threads(part));
    };
    for (Part& part : parts_) {
      if (is_alone(part)) body(part, parallel.threads());
    }
    parallel.for_tasks(parts_.size(), [&](std::size_t p) {
      if (!is_alone(parts_[p])) body(parts_[p], 1);
    });
  }

  std::vector<Part> parts_;
  std::size_t first_idle_row_, num_rows_;
  bool is_by_cholmod_;
  double compliance_ = 0.0;
  std::vector<double> compliance_weights_;
  Summary summary_;
};

}  // namespace tanor::detail
