#pragma once

#include <array>
#include <span>
#include <tuple>
#include <type_traits>
#include <vector>

#include "base/block3.hpp"
#include "evaluate/family.hpp"
#include "evaluate/tangents.hpp"
#include "evaluate/tuple_family.hpp"
#include "kinds/kernels.hpp"
#include "system/neighbourhoods.hpp"
#include "system/numbering.hpp"

namespace tanor::detail {

/// The type of the loops over the members of a kernel.
template <class Kernel>
using FamilyOf = std::conditional_t<std::is_base_of_v<Tuples, Kernel>, TupleFamily<Kernel>, Family<Kernel>>;

/// The families of all kinds, in the order of their list.
template <class Kinds>
struct FamiliesOf;
template <class... Groups>
struct FamiliesOf<std::variant<Groups...>> {
  template <class... Kernels>
  static std::tuple<FamilyOf<Kernels>...> families_of(const std::tuple<Kernels...>&);
  using Tuple = decltype(std::tuple_cat(families_of(std::declval<typename KernelsOf<Groups>::List>())...));
};

/// All constraints of a system at one instant. Arrays are in the inner order: r, v, w have 3n numbers, point by point,
/// and rows d. K is stored as `num_blocks` blocks of 3 numbers each, whose points and rows `list_incidences` gives.
/// Rows of contacts (see Tangents) use the tangent directions of the last configuration at which gradients were
/// evaluated.
class Constraints {
  using Families = FamiliesOf<Constraint>::Tuple;

 public:
  /// The members of each family that take part.
  using Selection = std::array<IndexRanges, std::tuple_size_v<Families>>;

  /// One-sided constraints that are open. Their blocks and numbers are 0. They are unit rows of S, so nothing is
  /// analysed anew when they close. Selections still evaluate them.
  class OpenRows {
   public:
    /// Opens rows, [row] not 0, and closes all others.
    void set(const Constraints& constraints, std::span<const char> is_open);
    bool have(std::size_t row) const { return !is_open_.empty() && is_open_[row] != 0; }
    std::size_t size() const { return rows_.size(); }
    /// Returns a number that changes with each change of the rows.
    std::size_t num_changes() const { return num_changes_; }
    void clear(double* rows) const {
      for (const Index row : rows_) rows[row] = 0.0;
    }
    void clear_blocks(double* blocks) const {
      for (const Index block : blocks_) store(blocks, block, Vec3{});
    }

   private:
    friend class Constraints;
    Selection others_;
    std::vector<Incidence> candidates_;
    std::vector<char> is_open_;  // [row]; empty until some are
    std::vector<Index> rows_, blocks_;
    std::size_t num_changes_ = 0;
  };
  OpenRows open;

  /// `t` is the instant of "initial" values that are measured from something that moves.
  Constraints(const System& system, const Numbering& numbering, double t = 0.0);

  std::size_t num_rows() const { return num_rows_; }
  std::size_t num_blocks() const { return num_blocks_; }
  bool depends_on_time() const;
  /// Returns the family of one kernel.
  template <class Kernel>
  const Family<Kernel>& family() const {
    return std::get<Family<Kernel>>(families_);
  }

  /// Returns true if all constraints are linear in r with constant coefficients, so that K never changes.
  bool gradients_are_constant() const;
  /// Returns true if |gradient| never changes, so that the diagonal of S does not either.
  bool gradient_norms_are_constant() const;
  /// Returns the exact |g|^2 of each block of K, or nothing if the norms change.
  std::vector<double> squared_gradient_norms() const;

  void set_time(double t);

  /// The offset of the rod in an inner row, m.
  struct RowOffset {
    std::size_t row;
    Vec3 offset;
  };
  /// Changes offsets of rods whose groups have some, for instance with a periodic cell. `offsets` ascend by rows.
  /// Solvers read them then (SchurSolver::read_offsets).
  void set_offsets(std::span<const RowOffset> offsets);

  /// Chooses the two unit vectors of lines by the rule of line_frame.hpp at the present time. Call this before
  /// evaluating a K that later instants refer to; there, the vectors are continued from here.
  void choose_frames() { std::get<Family<LineKernel>>(families_).kernel.normals.choose(); }
  /// Returns a number that changes when the vectors of a line jump. Multipliers from before a jump mean something else.
  std::size_t frames() const { return family<LineKernel>().kernel.normals.frames(); }
  /// Turns the blocks `others` of lines at another instant in their planes, to be as near to `blocks` as possible.
  void turn_frames(const double* blocks, double* others) const;

  /// Evaluates xi [d]; returns the largest relative violation.
  double evaluate_values(const Parallel& parallel, const double* r, double* xi) const;
  /// Evaluates K'v + xi_t [d]; returns the largest |.|/|gradient|, m/s.
  double evaluate_rates(const Parallel& parallel, const double* r, const double* v, double* rate) const;
  void evaluate_gradients(const Parallel& parallel, const double* r, double* blocks);
  /// Evaluates phi + K'w0 [d], and the blocks of K at r unless `blocks` is null. Returns the largest |.|/|gradient|,
  /// m/s^2.
  double evaluate_right_side(const Parallel& parallel, const double* r, const double* v, const double* w0, double* phi,
                             double* blocks);
  /// Computes y = K'x + shift [d] from stored blocks; returns the largest |y|/|gradient|. `shift` may be null.
  double apply_transposed(const Parallel& parallel, const double* blocks, const double* x, const double* shift,
                          double* y) const;

  /// Returns the members whose first row has a `takes_part` [row] that is not 0.
  Selection select(std::span<const char> takes_part) const;
  /// These evaluate some members. Rows and blocks of the others stay as they are, and contacts take no part.
  double evaluate_values(const Parallel& parallel, const Selection& some, const double* r, double* xi) const;
  double evaluate_rates(const Parallel& parallel, const Selection& some, const double* r, const double* v,
                        double* rate) const;
  void evaluate_gradients(const Parallel& parallel, const Selection& some, const double* r, double* blocks) const;
  double evaluate_right_side(const Parallel& parallel, const Selection& some, const double* r, const double* v,
                             const double* w0, double* phi, double* blocks) const;
  double apply_transposed(const Parallel& parallel, const Selection& some, const double* blocks, const double* x,
                          const double* shift, double* y) const;
  bool gradients_are_constant(const Selection& some) const;

  /// Writes the relative violation |xi|/|gradient|/length and |K'v + xi_t|/|gradient| (m/s) of each row.
  void measure(const double* r, const double* v, double* position, double* velocity) const;

  std::vector<Incidence> list_incidences() const;
  /// Returns the contacts with friction, which most systems do not have.
  const Tangents& tangents() const { return tangents_; }
  Tangents& tangents() { return tangents_; }

  /// Writes phi + T'w0, the acceleration of sliding, into the contacts' own rows alone; returns the largest, m/s^2.
  double evaluate_contacts(const Parallel& parallel, const double* r, const double* v, const double* w0,
                           Tangents::Which which, double* phi);

  /// The rods as pairs of points. `evaluate_rod_derivatives` writes, rod by rod, the share of each in the derivative of
  /// K lambda in positions: lambda (I - u u')/L of the force on j in r_j (see Coupling).
  std::vector<Coupling> list_rods() const;
  void evaluate_rod_derivatives(const Parallel& parallel, const double* r, const double* lambda, Block3* to) const;

  /// Lists which points act on which by constraints other than rods: all ordered pairs of a member's points, member by
  /// member. `evaluate_curvatures` writes their blocks of -sum of lambda_a Hess xi_a, N/m. See constraint_hessians.cpp.
  std::vector<Influence> list_curved() const;
  void evaluate_curvatures(const double* r, const double* lambda, Block3* to) const;
  /// Adds the sum over all rows a of Hess(xi_a) y_a to `to` [3n], the sum of K's derivatives along the y_a. Each y_a is
  /// stored in `moves` as row a of K is in its blocks; that of a rod is the move of its second point beside the first.
  void add_hessian_products(const double* r, const double* moves, double* to) const;

  /// Writes the lengths that violations are measured by, m [d]. Rows of contacts are left alone.
  void write_lengths(double* lengths) const;

 private:
  template <class Visit>
  void for_each_family(const Visit& visit) {
    std::apply([&](auto&... family) { (visit_nonempty(family, visit), ...); }, families_);
  }
  template <class Visit>
  void for_each_family(const Visit& visit) const {
    std::apply([&](const auto&... family) { (visit_nonempty(family, visit), ...); }, families_);
  }
  template <class F, class Visit>
  static void visit_nonempty(F& family, const Visit& visit) {
    if (family.size() > 0) visit(family);
  }

  /// Returns the largest measure(family, its members) of the families with members in `some`.
  template <class Measure>
  double largest(const Selection& some, const Measure& measure) const {
    double result = 0.0;
    std::size_t number = 0;
    const auto visit = [&](const auto& family, const IndexRanges& members) {
      if (members.size() > 0) result = larger(result, measure(family, members));
    };
    std::apply([&](const auto&... family) { (visit(family, some[number++]), ...); }, families_);
    return result;
  }

  Families families_;
  Selection everything_;
  Tangents tangents_;
  std::vector<double> shifted_, nothing_, turns_;  // [3n], [3n], [3][d] scratch of contacts on guides that turn
  std::size_t num_points_ = 0, num_rows_ = 0, num_blocks_ = 0;
};

}  // namespace tanor::detail
