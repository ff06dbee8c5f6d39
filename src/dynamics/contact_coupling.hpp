#pragma once

#include <vector>

#include "dynamics/workspace.hpp"
#include "friction/laws.hpp"

namespace tanor {

/// How friction enters the equations (31): b += K'M^-1 tau in rows and w0 += M^-1 tau at points, for tau = sum of
/// x_p e_p (see FrictionLaws).
///
/// Friction touches the rows that share its point, except those of its own guides: tau lies along T, and T'K_g = 0.
/// A user's law may push anywhere, so that it touches them all. Rows are *touched* if some contact touches them; there
/// are often few of them.
class ContactCoupling {
 public:
  /// Both must outlive it.
  ContactCoupling(const Workspace& work, const FrictionLaws& laws);

  /// K as `blocks`, which must stand until the next call, and the directions e of the laws at the same configuration.
  void set_place(const double* blocks);

  std::size_t num_touched_rows() const { return touched_rows_.size(); }
  /// The numbers of b [rows] in touched rows, into `touched` [touched rows].
  void gather(const double* b, double* touched) const;
  /// rows := base + K'M^-1 tau, x [parts], in touched rows alone; base [touched rows].
  void write_sum(const double* base, const double* x, double* rows) const;
  /// The same without a base.
  void write(const double* x, double* rows) const;
  /// b += sign K'M^-1 tau [rows].
  void add_to_rows(double sign, const double* x, double* b) const;
  /// b += K'M^-1 of one force at a contact along T, N.
  void add_force(std::size_t contact, Vec3 force, double* b) const;

  /// w += factor M^-1 tau [3n], tau [3 contacts].
  void add_to_points(double factor, const double* tau, double* w) const;
  /// w += factor M^-1 (tau - before).
  void add_change(double factor, const double* tau, const double* before, double* w) const;

 private:
  bool touches(const Incidence& incidence, std::size_t contact) const;
  double row(std::size_t touched, const double* x) const;

  struct Touch {
    Index block;
    double weight;  // of the block: its sign over the mass
  };
  struct Share {
    Index part;
    double size;  // weight g'e at the last place
  };
  const Model& model_;
  const Tangents& tangents_;
  const FrictionLaws& laws_;
  std::vector<Touch> touches_;                                   // row after row
  std::vector<Share> shares_;                                    // [touch]
  std::vector<Index> touched_rows_, touch_start_;                // [touched row], [touched row + 1]
  std::vector<std::vector<std::size_t>> incidences_of_contact_;  // that it touches, of the model's
  const double* blocks_ = nullptr;                               // K at the last place
};

}  // namespace tanor
