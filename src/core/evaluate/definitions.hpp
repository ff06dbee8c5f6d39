#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include <tanor/expression.hpp>
#include <tanor/system.hpp>

#include "base/parallel.hpp"
#include "base/vec3.hpp"

namespace tanor::detail {

/// The recorded definition of one group. Its variables are the coordinates of a member's points (three each), then
/// functions of time.
struct RecordedDefinition {
  Expression expression;                  ///< results are the rows of a member
  std::vector<ScalarFunction> functions;  ///< shared by all members
  bool has_parameter = false;             ///< the last variable is each member's own, see Definitions::parameter
};

/// Evaluates every constraint a second time. xi comes from the definition of its kind, straight from the System, on
/// dual numbers (dual.hpp), which yield all derivatives. This class shares nothing with the families and their
/// hand-written kernels, so it can verify them. With kinds that run on their definition (jet_kernel.hpp) it shares the
/// definition, but not the arithmetic that takes derivatives of it. Users' own kernels are their own definition.
///
/// All arrays are in the user's order of points and rows. The two unit vectors of a line are those of line_frame.hpp.
class Definitions {
 public:
  /// `system` must outlive this. `t0` is the instant of "initial" values that are measured from something that moves,
  /// at `positions`, which are those of the system if they are not given.
  Definitions(const System& system, double t0, const double* positions = nullptr);

  std::size_t num_rows() const { return num_rows_; }

  /// Computes the derivatives along the curve (r + e v + e^2/2 w, t + e) at e = 0, each [d]: xi, rate = K'v + xi_t and
  /// second = K'w + phi. r, v, w are [3n].
  void taylor(const Parallel& parallel, double t, std::span<const double> r, std::span<const double> v,
              std::span<const double> w, std::span<double> xi, std::span<double> rate, std::span<double> second) const;

  /// Calls use(row, point, force) with the parts of eta = K lambda.
  using UseReaction = std::function<void(std::size_t row, Index point, const Vec3& force)>;
  void for_each_reaction(double t, std::span<const double> r, std::span<const double> lambda,
                         const UseReaction& use) const;
  /// Computes eta [3n].
  void reactions(double t, std::span<const double> r, std::span<const double> lambda, std::span<double> eta) const;

  /// Returns group `group` as an expression, or nothing if it cannot be recorded. The two unit vectors of lines that
  /// turn come from `axis`, which holds for as long as the rule chooses that axis. The expression is that of all
  /// members with as many points as `member`.
  std::optional<RecordedDefinition> record(std::size_t group, std::optional<LineAxis> axis = {},
                                           std::size_t member = 0) const;
  /// Returns the parameter of member k of a group.
  ScalarFunction parameter(std::size_t group, std::size_t k) const;

  /// Computes y = K'u [d], the rate of xi along u while time stands.
  void transposed(const Parallel& parallel, double t, std::span<const double> r, std::span<const double> u,
                  std::span<double> y) const;

 private:
  /// The data of a group at the start.
  struct Start {
    std::size_t first_row = 0;
    std::vector<double> values;  ///< [member] of a parameter that is "initial", or empty
  };

  /// Calls use(row, xi) with xi over T at the points `at`, and use_tuples(first row, group, values) for users' own
  /// kernels, which read r and v [3n]. v may be null.
  template <class T, class At, class Use, class UseTuples>
  void for_each_row(const Parallel& parallel, double t, const double* r, const double* v, const At& at, const Use& use,
                    const UseTuples& use_tuples) const;

  /// Calls use(row, point, gradient) for each point of each row, which is a column of K.
  template <class Use>
  void for_each_gradient(double t, std::span<const double> r, const Use& use) const;

  const System& system_;
  std::vector<Start> starts_;  // [group]
  Index first_outside_;        // points of members that were taken out
  std::size_t num_rows_ = 0;
};

}  // namespace tanor::detail
