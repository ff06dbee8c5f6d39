#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "base/numbers.hpp"
#include "certificate/certificate.hpp"
#include "certificate/second_factor.hpp"
#include "evaluate/definitions.hpp"

namespace tanor {

/// Tries one answer, identity by identity, and writes the certificate.
class Verifier {
 public:
  Verifier(Forms& forms, const Answer& answer, SecondWay way);

  Certificate verify();

 private:
  using Vector = std::vector<double>;

  /// The largest of some relative errors, and where it was.
  struct Worst {
    double error = 0.0;
    std::size_t index = 0;

    void see(double value, std::size_t i) {
      if (!(value <= error)) {
        error = value;
        index = i;
      }
    }
  };

  // ---- words, in verifier.cpp ----
  void measure_scale();
  void add(double* figure, const std::string& identity, double error, double allowed, const std::string& where);
  void add_row(double* figure, const std::string& identity, const Worst& worst, double allowed);
  void add_point(double* figure, const std::string& identity, const Worst& worst, double allowed);
  Worst worst_point(const Vector& difference, double scale) const;
  /// Each point beside the scale of its own neighbourhood: another one, however fast, hides nothing.
  Worst worst_point(const Vector& difference, const Vector& scale) const;
  double speed_at(std::size_t point) const { return work_.scales.speed(work_.scales.of_point(point)); }
  double at_point(const Vector& scale, std::size_t point) const { return scale[work_.scales.of_point(point)]; }
  /// The same of M^1/2 times the difference.
  Worst worst_point_by_M(const Vector& difference, double scale) const;
  Vector to_user(const Vector& inner) const;
  /// [rows] from the user's [d]; contacts: 0.
  Vector inner_rows(const Vector& user) const;
  /// In (-1, 1), independent of everything but the seed: no identity may hold by chance.
  double random_number();
  Vector random_points();
  /// M^-1/2 z: no point counts more than others, whatever their masses.
  Vector random_points_by_M();
  /// pass() corrects and returns the size of what it did: on until nothing is gained.
  template <class Pass>
  static void repeat(int most_passes, const Pass& pass) {
    double before = std::numeric_limits<double>::infinity();
    for (int k = 0; k < most_passes; ++k) {
      const double size = pass();
      if (!(size < 0.5 * before)) break;
      before = size;
    }
  }
  /// sum of m x y over the moving points
  double product(const Vector& x, const Vector& y) const;
  double norm_of(const Vector& x) const;
  /// Directions are differences of places: what their rounding does, eps |r|/L, and across nearly straight angles.
  double rounding_of_places() const;
  double measure_angles() const;
  static constexpr double fewest_digits = Certificate::fewest_digits;
  /// What one solve with a matrix of this reciprocal condition may lose.
  static double conditioned(double reciprocal_condition) { return std::max(1e-11, 1e3 * eps / reciprocal_condition); }
  /// How often it is repeated on what is left over: once where it proves nine digits by itself, else until nothing is
  /// gained (masses that differ by 1e9 leave S without digits of its own, not what refinement makes of it).
  static int most_passes(double reciprocal_condition) { return conditioned(reciprocal_condition) <= 1e-9 ? 1 : 10; }
  /// The same after one refinement.
  static double refined(double reciprocal_condition) { return std::max(1e-9, 10.0 * eps / reciprocal_condition); }

  /// How identities write it: f, with friction f + tau.
  std::string given_force() const { return has_friction_ ? "f + tau" : "f"; }
  std::string minus_given_force() const { return has_friction_ ? "- f - tau" : "- f"; }
  bool is_users(std::size_t inner_row) const { return user_row(inner_row) < d_; }
  std::size_t user_row(std::size_t inner_row) const {
    return static_cast<std::size_t>(model_.numbering.user_row[inner_row]);
  }

  void verify_energies();
  void verify_free();

  // ---- constraints, in verify_constraints.cpp ----
  void verify_constraints();
  void verify_equations(const Definitions& definitions, const Vector& user_v);
  void turn_pairs_of_lines(const Definitions& definitions, Vector* lambda) const;
  Vector measure_rows(const Vector& weights) const;
  Vector measure_curvature(const Definitions& definitions, const Vector& user_v);
  void verify_power(const Definitions& definitions, const Vector& user_v, const Vector& lambda, const Vector& eta);
  Vector project_onto_tangent(const Vector& u);
  void verify_normal_projector(const Definitions& definitions);
  void verify_split();
  /// max over the rows of |K'u|/|gradient| by the second definition.
  Worst rows_of(const Definitions& definitions, const Vector& u, const Vector& row_norms, double size) const;

  // ---- friction, in verify_friction.cpp ----
  struct Sliding;
  void verify_friction(const Definitions& definitions);
  std::vector<Sliding> measure_sliding(const Definitions& definitions) const;
  void verify_law(const std::vector<Sliding>& contacts);
  void verify_rest(const std::vector<Sliding>& contacts);
  void verify_friction_by_blocks();

  // ---- factors of their own, in verify_by_second_factor.cpp ----
  void verify_by_second_factor();
  void compare_multipliers(const Vector& lambda);
  void verify_euclidean(const Definitions& definitions);
  void make_gamma();
  Vector project_onto_normal(const Vector& u);
  void verify_direct_problem(double allowed);
  void verify_both_euclidean(const Vector& u, const Vector& u_N);

  // ---- coordinates, alone and beside constraints, in verify_coordinates.cpp ----
  Vector project_by_coordinates(const Vector& u);
  void verify_coordinates();
  void verify_curve();
  void verify_both();
  void verify_identity(const std::string& identity, double allowed);
  void solve_other();
  void compare_forms();

  Forms& forms_;
  Workspace& work_;
  const Model& model_;
  const Answer& answer_;
  const SecondWay way_;
  const std::size_t n_, moving_, d_, num_rows_;  // d_: the user's rows; num_rows_: with those of contacts
  const bool has_friction_, something_sticks_;
  Certificate result_;
  std::uint64_t random_ = 20261;
  Vector K_;   // blocks at the answer, evaluated afresh; without contacts: what holds those that stick is given
  Vector w0_;  // M^-1 (f + tau)
  Vector user_r_, row_norms_, phi_;
  Vector other_w_, other_eta_;
  std::optional<SecondFactor> second_, own_gamma_;
  SecondFactor* gamma_ = nullptr;  // own_gamma_; or second_ where all masses are equal: Gamma = m S
  Vector gamma_scale_;             // [point] 1; 1/m where second_ serves; supports: 0
  bool has_both_ = false;
  double rcond_of_S_ = 1.0, rcond_of_H_ = 1.0, rcond_of_Gamma_ = 1.0;
  Vector acceleration_, scale_;  // [neighbourhood], m/s^2: the largest of w, M^-1 f and M^-1 eta; with phi
  double inverse_sine_ = 1.0;    // of angles
};

}  // namespace tanor
