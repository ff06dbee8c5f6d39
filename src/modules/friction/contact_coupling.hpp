#pragma once

#include <vector>

#include "dynamics/workspace.hpp"
#include "friction/laws.hpp"

namespace tanor::detail {

/// The terms of friction in the equations (31): b += K'M^-1 tau in rows and w0 += M^-1 tau at points, for tau = sum of
/// x_p e_p (see FrictionLaws).
///
/// Friction touches the rows that share its point, except those of its own guides, since tau lies along T and
/// T'K_g = 0. A user's law may push in any direction, so it touches them all. A row is *touched* if some contact
/// touches it; often few rows are.
class ContactCoupling {
 public:
  /// Both arguments must outlive this object.
  ContactCoupling(const Workspace& work, const FrictionLaws& laws);

  /// Sets K, as `blocks`, which must stay valid until the next call. The laws must have their directions e at the same
  /// configuration.
  void set_place(const double* blocks);

  std::size_t num_touched_rows() const { return touched_rows_.size(); }
  /// Copies the touched rows of b [rows] into `touched` [touched rows].
  void gather(const double* b, double* touched) const;
  /// Computes rows := base + K'M^-1 tau in the touched rows alone, for x [parts] and base [touched rows], or null for
  /// 0.
  void write(const double* base, const double* x, double* rows) const;
  /// Adds sign K'M^-1 tau to b [rows].
  void add_to_rows(double sign, const double* x, double* b) const;
  /// Adds K'M^-1 of one force at a contact along T, N, to b.
  void add_force(std::size_t contact, Vec3 force, double* b) const;

  /// Adds factor M^-1 tau to w [3n], for tau [3 contacts].
  void add_to_points(double factor, const double* tau, double* w) const;
  /// Adds factor M^-1 (tau - before) to w.
  void add_change(double factor, const double* tau, const double* before, double* w) const;

 private:
  bool touches(const Incidence& incidence, std::size_t contact) const;
  double row(std::size_t touched, const double* x) const;

  struct Touch {
    Index block;
    double weight;  // factor of the block: its sign over the mass
  };
  struct Share {
    Index part;
    double size;  // weight g'e at the last configuration
  };
  const Model& model_;
  const Tangents& tangents_;
  const FrictionLaws& laws_;
  std::vector<Touch> touches_;                                   // row after row
  std::vector<Share> shares_;                                    // [touch]
  std::vector<Index> touched_rows_, touch_start_;                // [touched row], [touched row + 1]
  std::vector<std::vector<std::size_t>> incidences_of_contact_;  // [contact] touched incidences of the model
  const double* blocks_ = nullptr;                               // K at the last configuration
};

}  // namespace tanor::detail
