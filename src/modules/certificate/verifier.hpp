#pragma once

#include <optional>
#include <string>
#include <vector>

#include "certificate/answer_measures.hpp"
#include "certificate/certificate.hpp"
#include "certificate/euclidean_split.hpp"
#include "certificate/random_vectors.hpp"
#include "certificate/second_factor.hpp"
#include "evaluate/definitions.hpp"

namespace tanor::detail {

/// An identity in the paper's symbols, and in plain words that can fail.
struct Identity {
  std::string symbols, words;
};

/// Verifies one answer, identity by identity, and writes the certificate.
class Verifier : private AnswerMeasures {
 public:
  Verifier(Forms& forms, const Answer& answer, SecondFactorization by);

  Certificate verify();

 private:
  // ---- findings, in verifier.cpp ----
  void measure_scale();
  void add(double* figure, const Identity& identity, double error, double allowed, const std::string& where);
  void add_row(double* figure, const Identity& identity, const Worst& worst, double allowed);
  void add_point(double* figure, const Identity& identity, const Worst& worst, double allowed);
  static constexpr double fewest_digits = Certificate::fewest_digits;
  /// Returns the given force as identities write it: f, with friction f + tau; after " - " each term has that sign.
  std::string given_force(const std::string& sign = "") const {
    return sign + "f" + (has_friction_ ? (sign.empty() ? " + " : sign) + "tau" : "");
  }

  void verify_energies();
  void verify_free();

  // ---- constraints, in verify_constraints.cpp ----
  void verify_constraints();
  void verify_equations(const Definitions& definitions, const Vector& user_v);
  std::vector<std::size_t> number_turning_lines() const;
  void turn_pairs_of_lines(const Definitions& definitions, Vector* lambda) const;
  Vector measure_rows(const Vector& weights) const;
  Vector measure_curvature(const Definitions& definitions, const Vector& user_v);
  void verify_branch(const Definitions& definitions, const Vector& user_v);
  void measure_cancellation(const Definitions& definitions);
  void verify_power(const Definitions& definitions, const Vector& user_v, const Vector& lambda, const Vector& eta);
  Vector project_onto_tangent(const Vector& u);
  void verify_normal_projector(const Definitions& definitions);
  void verify_split();
  /// Returns the maximum over the rows of |K'u|/|gradient| by the second definition.
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
  void verify_direct_problem(double allowed);
  Vector tangent_part(const Vector& u);
  void verify_both_euclidean(const Vector& u, const Vector& u_T);

  // ---- coordinates, alone and beside constraints, in verify_coordinates.cpp ----
  Vector project_by_coordinates(const Vector& u);
  void verify_coordinates();
  void verify_curve();
  void verify_both();
  void verify_identity(const std::string& symbols, double allowed);
  void solve_other();
  void compare_forms();

  const SecondFactorization second_factorization_;
  const bool has_friction_, something_sticks_;
  Certificate result_;
  RandomVectors random_;
  Vector K_;   // blocks at the answer, evaluated afresh, without contacts: what holds those that stick is given
  Vector w0_;  // M^-1 (f + tau)
  Vector user_r_, row_norms_, phi_;
  Vector other_w_, other_eta_;
  std::optional<SecondFactor> second_;
  std::optional<EuclideanSplit> euclidean_;
  bool has_both_ = false;
  double rcond_of_S_ = 1.0, rcond_of_H_ = 1.0;
  Vector acceleration_, scale_;  // [neighbourhood], m/s^2: largest of w and M^-1 (f, tau, eta); same with phi
};

}  // namespace tanor::detail
