#pragma once

#include <array>
#include <span>
#include <tuple>
#include <vector>

#include "base/block3.hpp"
#include "evaluate/family.hpp"
#include "evaluate/linear_family.hpp"
#include "evaluate/tangents.hpp"
#include "evaluate/user_family.hpp"
#include "kinds/kernels.hpp"
#include "system/neighbourhoods.hpp"
#include "system/numbering.hpp"

namespace tanor {

/// The loops over the members of a kernel.
template <class Kernel>
struct FamilyOf {
  using Type = Family<Kernel>;
};
template <>
struct FamilyOf<LinearKernel> {
  using Type = LinearFamily;
};
template <>
struct FamilyOf<UserKernels> {
  using Type = UserFamily;
};

/// The families of all kinds, in the order of their list.
template <class Kinds>
struct FamiliesOf;
template <class... Groups>
struct FamiliesOf<std::variant<Groups...>> {
  template <class... Kernels>
  static std::tuple<typename FamilyOf<Kernels>::Type...> families_of(const std::tuple<Kernels...>&);
  using Tuple = decltype(std::tuple_cat(families_of(std::declval<typename KernelsOf<Groups>::List>())...));
};

/// All constraints of a system at one instant. Arrays are in the inner order: r, v, w 3n, point by point; rows d;
/// K is stored as its blocks, 3 numbers each (`num_blocks`), whose places `list_incidences` tells. Rows of contacts
/// (see Tangents) use the tangent directions at the last place where gradients were evaluated.
class Constraints {
  using Families = FamiliesOf<Constraint>::Tuple;

 public:
  /// `t`: where "initial" values stand when they are measured from something that moves.
  Constraints(const System& system, const Numbering& numbering, double t = 0.0);

  std::size_t num_rows() const { return num_rows_; }
  std::size_t num_blocks() const { return num_blocks_; }
  bool depends_on_time() const;
  /// Those of one kind.
  template <class Kernel>
  const Family<Kernel>& family() const {
    return std::get<Family<Kernel>>(families_);
  }

  /// All constraints are linear in r with constant coefficients: K never changes.
  bool gradients_are_constant() const;
  /// |gradient| never changes, so the diagonal of S does not either.
  bool gradient_norms_are_constant() const;
  /// Then |g|^2 of each block of K, exact; else empty.
  std::vector<double> squared_gradient_norms() const;

  void set_time(double t);

  /// The two unit vectors of lines by their rule (line_frame.hpp) at the present time: where K is about to be evaluated
  /// for others to stand on. At other times they are continued from here.
  void choose_frames() { std::get<Family<LineKernel>>(families_).kernel.normals.choose(); }
  /// Another number where those of some line have jumped: multipliers from before mean something else.
  std::size_t frames() const { return family<LineKernel>().kernel.normals.frames(); }
  /// The blocks of such lines at another instant, turned in their planes to be as near to `blocks` as they can.
  void turn_frames(const double* blocks, double* others) const;

  /// xi [d]; returns the largest relative violation.
  double evaluate_values(const Parallel& parallel, const double* r, double* xi) const;
  /// K'v + xi_t [d]; returns the largest |.|/|gradient|, m/s.
  double evaluate_rates(const Parallel& parallel, const double* r, const double* v, double* rate) const;
  void evaluate_gradients(const Parallel& parallel, const double* r, double* blocks);
  /// phi + K'w0 [d]; the blocks of K at r as well unless `blocks` is null. Returns the largest |.|/|gradient|, m/s^2.
  double evaluate_right_side(const Parallel& parallel, const double* r, const double* v, const double* w0, double* phi,
                             double* blocks);
  /// y = K'x + shift [d] from stored blocks; returns the largest |y|/|gradient|. `shift` may be null.
  double apply_transposed(const Parallel& parallel, const double* blocks, const double* x, const double* shift,
                          double* y) const;

  /// Of each family the members that take part.
  using Selection = std::array<Runs, std::tuple_size_v<Families>>;
  /// Those with the rows where `takes_part` [row] is not 0.
  Selection select(std::span<const char> takes_part) const;
  /// As above, of some members: rows and blocks of others stay as they are, and contacts take no part.
  double evaluate_values(const Parallel& parallel, const Selection& some, const double* r, double* xi) const;
  double evaluate_rates(const Parallel& parallel, const Selection& some, const double* r, const double* v,
                        double* rate) const;
  void evaluate_gradients(const Parallel& parallel, const Selection& some, const double* r, double* blocks) const;
  double evaluate_right_side(const Parallel& parallel, const Selection& some, const double* r, const double* v,
                             const double* w0, double* phi, double* blocks) const;
  double apply_transposed(const Parallel& parallel, const Selection& some, const double* blocks, const double* x,
                          const double* shift, double* y) const;
  bool gradients_are_constant(const Selection& some) const;

  /// Relative violation |xi|/|gradient|/length and |K'v + xi_t|/|gradient| (m/s) of each row.
  void measure(const double* r, const double* v, double* position, double* velocity) const;

  std::vector<Incidence> list_incidences() const;
  /// Contacts with friction: none in most systems.
  const Tangents& tangents() const { return tangents_; }
  Tangents& tangents() { return tangents_; }

  /// Into the contacts' own rows alone: phi + T'w0, the acceleration of sliding; returns the largest, m/s^2.
  double evaluate_contacts(const Parallel& parallel, const double* r, const double* v, const double* w0,
                           Tangents::Which which, double* phi);

  /// Rods as pairs of points, and the derivative of K lambda in positions that is theirs, rod by rod:
  /// lambda (I - u u')/L of the force on j in r_j (see Coupling).
  std::vector<Coupling> list_rods() const;
  void evaluate_rod_derivatives(const Parallel& parallel, const double* r, const double* lambda, Block3* to) const;

  /// Of all constraints but rods: whose points answer to whose (all ordered pairs of a member's points, row by row),
  /// and the blocks of -sum of lambda_a Hess xi_a that are theirs, N/m. In constraint_hessians.cpp.
  std::vector<Influence> list_curved() const;
  void evaluate_curvatures(const double* r, const double* lambda, Block3* to) const;

  /// The lengths that violations are measured by, m [d]; rows of contacts are left alone.
  void write_lengths(double* lengths) const;
  /// Shortest of the lengths that violations are measured by, m; at most `scene_size`.
  double smallest_length(double scene_size) const;

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

  /// visit(family, its members) of those that have some.
  template <class Visit>
  void for_each_family(const Selection& some, const Visit& visit) const {
    std::size_t number = 0;
    const auto visit_one = [&](const auto& family, const Runs& members) {
      if (members.size() > 0) visit(family, members);
    };
    std::apply([&](const auto&... family) { (visit_one(family, some[number++]), ...); }, families_);
  }

  Families families_;
  Selection everything_;
  Tangents tangents_;
  std::vector<double> shifted_, nothing_, turns_;  // [3n], [3n], [3][d] scratch of contacts on guides that turn
  std::size_t num_points_ = 0, num_rows_ = 0, num_blocks_ = 0;
};

}  // namespace tanor
