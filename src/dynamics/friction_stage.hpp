#pragma once

#include <functional>
#include <string>
#include <vector>

#include "dynamics/instant.hpp"
#include "dynamics/model.hpp"
#include "friction/contraction.hpp"
#include "friction/enumeration.hpp"
#include "friction/fixed_point.hpp"
#include "friction/laws.hpp"

namespace tanor {

/// Contacts of one island that slide, and their friction as a small problem of its own; `members` may be empty.
struct SlidingIsland {
  std::size_t number = 0;
  std::vector<std::size_t> members;
  SlidingContacts contacts;
};

/// Friction as a part of the normal form: tau(r, v, t, lambda) such that
///
///   S lambda + K'M^-1 tau(lambda) = -(phi + K'M^-1 f)                         (*), (43)
///
/// Each evaluation of tau(lambda) is one solve with the factor of S that stands; Newton's steps take more of them. With
/// tau found, it is a given force.
class FrictionStage final : private Response {
 public:
  /// x = -S^-1 b, both [rows], refined to rounding or not.
  using Solve = std::function<void(const double* b, double* x, bool refines)>;
  /// `blocks`: K, always at the present place.
  FrictionStage(Model& model, FrictionMethod method, const std::vector<double>& blocks, Solve solve);

  FrictionLaws& laws() { return laws_; }

  /// Accelerations beside which others are small [neighbourhood], m/s^2: what friction is measured by where it
  /// vanishes.
  void set_accelerations(const std::vector<double>& accelerations);
  /// tau at (t, r, v) for b = phi + K'w0 [rows]; `lambda` [rows]: a guess.
  Outcome find(double t, const double* r, const double* v, const double* b, Judgement judgement, const double* lambda);
  /// Once more from lambda near the answer, with refined solves; b without friction.
  void polish(const double* b, const double* lambda);
  /// tau into w0 and b: w0 += sign M^-1 tau [3n], b += sign K'M^-1 tau [rows].
  void add(double sign, double* w0, double* b) const;
  /// tau := tau(lambda), y += s M^-1 dtau [3n]; returns |dtau| over the largest friction. And the same change again.
  double change_to(const double* lambda, double s, double* y);
  void add_change(double s, double* y) const;
  /// |tau(lambda) - tau| over the largest friction, into the report.
  double measure(const double* lambda);

  // Into tau [3n], N.
  void add_all(const double* lambda, double* tau) const;
  /// But what the rows of contacts that stick hold.
  void add_given(double* tau) const { add_to_points(tau_.data(), tau); }
  void add_at(const double* lambda, double* tau) const;  ///< the law at lambda
  /// Of all friction, W; and of the contacts that stick alone.
  double power(const double* lambda, const double* v) const;
  double held_power(const double* lambda, const double* v) const;

  /// Contacts of each island that has some.
  const std::vector<std::vector<std::size_t>>& islands() const { return islands_; }
  std::size_t island_of(std::size_t contact) const { return island_of_contact_[contact]; }
  /// Directions of sliding at a place, with K there.
  void set_place(double t, const double* r, const double* v);
  /// tau of what does not follow Coulomb's law alone: given forces, and a user's laws at lambda.
  void set_given(double t, const double* r, const double* v, const double* lambda);
  /// b += K'M^-1 of a force along T at a contact [rows].
  void add_force(std::size_t contact, Vec3 force, double* b) const;
  /// Friction of a contact now, whether it sticks or slides, N.
  Vec3 force(std::size_t contact, const double* lambda) const;
  /// Islands [of `islands`] whose motions were counted already, all modes tried: they are not judged.
  void set_counted(std::vector<char> is_counted) { is_counted_ = std::move(is_counted); }

  std::size_t num_sticking() const { return tangents_.num_sticking(); }
  const FrictionReport& report() const { return report_; }
  /// Several solutions are a failure (else: the one nearest to the guess is taken, and the report says so).
  void refuse_several(bool refuses) { several_are_refused_ = refuses; }

  void exchange_memory(Memory& memory) {
    memory.exchange(x_, tau_);
    laws_.exchange_memory(memory);
  }

  /// Largest friction that contact c could hold, and the one it holds (lambda of its rows), N.
  double static_limit(std::size_t contact, const double* lambda) const;
  Vec3 held(std::size_t contact, const double* lambda) const;

 private:
  bool feels(const Incidence& incidence, std::size_t contact) const;
  void set_right_side(const double* b);
  void find_multipliers(const double* x, double* lambda) override;
  void find_change(const double* x, double* lambda) override;
  void add_to_points(const double* of_contacts, double* tau) const;
  double felt(std::size_t touched_row, const double* x) const;
  void set_forces(const double* lambda);
  Outcome iterate(double t, const double* guess, double* lambda);

  // In friction_islands.cpp.
  void list_sliding();
  void reduce();
  bool are_small(std::size_t most) const;
  double amplification_of_full_reactions() const;
  std::string name_island(const SlidingIsland& island) const;
  bool is_counted(const SlidingIsland& island) const { return !is_counted_.empty() && is_counted_[island.number] != 0; }
  bool holds_what_sticks(const SlidingIsland& island, const Eigen::VectorXd& sizes);
  Outcome refuse_several_of(const SlidingIsland& island, std::size_t count, double t);
  Outcome judge(double t);
  void leave_out_uncoupled(std::size_t least_contacts);
  static constexpr std::size_t most_judged = 64;  // contacts of an island, one solve each
  Outcome enumerate(double t, double* lambda);

  Outcome fail(Status status, double t, const std::string& why) const;
  double relative_change();

  Model& model_;
  const Tangents& tangents_;
  const FrictionMethod method_;
  const std::vector<double>& blocks_;
  Solve solve_;
  bool refines_ = false;
  FrictionLaws laws_;
  FixedPoint fixed_point_;
  // K'M^-1 tau, row after row: a touched row += weight g'e x_p. What guides a contact does not feel its friction along
  // the guide, nor does what would hold it.
  struct Touch {
    Index block;
    double weight;
  };
  struct Share {
    Index part;
    double size;  // weight g'e at the last place
  };
  std::vector<Touch> touches_;
  std::vector<Share> shares_;                                    // [touch]
  std::vector<Index> touched_rows_, touch_start_;                // [touched row], [touched row + 1]
  std::vector<std::vector<std::size_t>> islands_;                // contacts of each island that has some
  std::vector<std::vector<std::size_t>> incidences_of_contact_;  // that feel its friction, of the model's
  std::vector<std::size_t> island_of_contact_;
  std::vector<char> is_counted_;        // [island]; empty: none is
  std::vector<SlidingIsland> sliding_;  // [island]; kept from step to step
  ContractionBound contraction_;
  std::vector<double> force_, response_to_force_;  // [parts], [rows], scratch
  double amplification_ = 0.0;                     // 1/(1 - L), L proven; else NaN
  bool several_are_refused_ = true;
  std::vector<double> right_side_;  // [rows] b where nothing is touched
  std::vector<double> b_touched_;   // [touched row]
  std::vector<double> change_;      // [rows] 0 there
  std::vector<double> lambda_, guess_;
  std::vector<double> x_, x_at_;                  // [parts]
  std::vector<double> tau_, tau_before_;          // [3 contacts] of x_
  std::vector<Index> group_of_part_;              // neighbourhoods that have contacts
  std::vector<std::size_t> neighbourhoods_;       // [group]
  std::vector<double> least_;                     // [group] N
  std::vector<double> largest_, largest_change_;  // [group] N, scratch
  FrictionReport report_;
};

}  // namespace tanor
