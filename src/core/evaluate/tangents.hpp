#pragma once

#include <array>
#include <span>
#include <utility>
#include <vector>

#include "base/vec3.hpp"
#include "evaluate/family.hpp"
#include "kinds/tables.hpp"
#include "system/contacts.hpp"
#include "system/numbering.hpp"

namespace tanor::detail {

/// Contacts at one instant: the directions T in which a guided point may slide, its velocity there relative to the
/// guide, and, for each contact that sticks, the rows
///
///   T'(v - u) = 0,   T'w = -phi,   phi = T_dot'(v - u) - T'u_dot        T'T = I, T'K_g = 0
///
/// u is the guide's own velocity along itself. On the guide v - u = K_g c, so T_dot'(v - u) = -T'K_g_dot c. A contact
/// that slides keeps its rows with gradient 0. They are unit rows of S, so nothing is analysed anew when it sticks.
class Tangents {
 public:
  struct Place {
    Index friction, point;  ///< in System::friction; inner point
    int num_guides;         ///< 1 on a surface, 2 on a wire
    std::array<Index, 2> guide_row, guide_block;
    Index first_row = -1, first_block = -1;  ///< its own; -1 if it cannot stick
    signed char side = 0;      ///< 1 or -1 where its guide acts to one side: the force is side lambda >= 0
    bool is_open = false;      ///< then it takes no part, and T is 0
    std::size_t velocity = 0;  // slot
    int num_tangents() const { return 3 - num_guides; }
  };

  Tangents() = default;
  /// `incidences` are those of the other constraints. Own blocks are numbered from `first_block` on.
  Tangents(const System& system, const Numbering& numbering, std::span<const Incidence> incidences, Index first_block);

  std::size_t size() const { return places_.size(); }
  std::size_t num_blocks() const { return num_blocks_; }
  const Place& operator[](std::size_t contact) const { return places_[contact]; }

  bool sticks(std::size_t contact) const { return sticks_[contact] != 0; }
  std::size_t num_sticking() const;
  void set_stick(std::size_t contact, bool sticks) {
    have_switched_ = have_switched_ || (sticks_[contact] != 0) != sticks;
    sticks_[contact] = sticks;
  }
  /// Opens the one-sided guide of a contact, or closes it.
  void set_open(std::size_t contact, bool is_open) {
    if (is_open) set_stick(contact, false);
    places_[contact].is_open = is_open;
  }
  bool is_open(std::size_t contact) const { return places_[contact].is_open; }
  /// Returns true if some contact began or ceased to stick since this was asked last.
  bool forget_switches() { return std::exchange(have_switched_, false); }
  /// Sets the place of a contact. If it is held, xi = T'(r - place) as long as it sticks; otherwise xi is 0.
  void set_place(std::size_t contact, bool is_held, const Vec3& place) { places_held_[contact] = {is_held, place}; }

  /// Returns the guide's velocity along itself, u.
  const MovingVec3& own_velocity(std::size_t contact) const { return velocities_[places_[contact].velocity]; }

  void set_time(double t) { velocities_.set_time(t); }
  bool depends_on_time() const { return !velocities_.is_constant(); }

  /// Evaluates T at the configuration of K (in `blocks`), and writes the blocks of the contacts' own rows.
  void write_gradients(const Parallel& parallel, double* blocks);
  /// Returns a contact whose guides leave no directions where T was written, since a gradient is 0 or the two of a wire
  /// are parallel. Returns `size()` if there is none.
  std::size_t find_undirected() const;
  /// Returns T of a contact, `num_tangents` vectors.
  const std::array<Vec3, 2>& directions(std::size_t contact) const { return directions_[contact]; }
  /// Returns K_g of a contact, `num_guides` vectors; the other one is 0.
  const std::array<Vec3, 2>& normals(std::size_t contact) const { return normals_[contact]; }
  /// Returns T T'(v - u), m/s.
  Vec3 sliding_velocity(std::size_t contact, const double* v) const;

  /// Writes xi of the rows, which is 0 where nothing is held.
  void write_values(const double* r, double* xi) const;
  /// Evaluates T'(v - u); returns the largest, m/s.
  double evaluate_rates(const double* v, double* rate) const;
  double apply_transposed(const double* blocks, const double* x, const double* shift, double* y) const;

  /// The contacts that count: those that stick, or all that could.
  enum class Which { Sticking, All };

  /// Returns for how many directions T_k the derivative T_dot matters at v. It is 0 if no point moves across its
  /// guides.
  int num_turning(const double* v, Which which) const;
  /// Writes v + s T_k at all contacts, where k is the first or second direction.
  void shift_velocities(int k, double s, const double* v, double* shifted) const;
  /// Evaluates phi + T'w0 of the rows; returns the largest. Unless null, `turn[k]` [d] is
  /// (phi_g(v + s T_k) - phi_g(v - s T_k))/(4 s) = T_k'K_g_dot of the guides' rows. The difference is exact, since phi
  /// is quadratic in v.
  double evaluate_right_side(const double* v, const double* w0, const std::array<const double*, 2>& turn, Which which,
                             double* phi) const;

  template <class Append>
  void list_incidences(const Append& append) const {
    for (const Place& place : places_) {
      for (int k = 0; place.first_row >= 0 && k < place.num_tangents(); ++k)
        append(Incidence{place.point, place.first_row + k, place.first_block + k, 1.0});
    }
  }

 private:
  /// Returns c = Gamma_g^-1 K_g'(v - u), or 0 where the guide is open.
  std::array<double, 2> across(std::size_t contact, const double* v) const;

  std::vector<Place> places_;
  std::vector<char> sticks_;
  bool have_switched_ = false;
  std::vector<std::array<Vec3, 2>> normals_, directions_;  // K_g, T
  std::vector<std::pair<bool, Vec3>> places_held_;         // [contact]
  VectorTable<AsGiven> velocities_;
  std::size_t num_blocks_ = 0;
};

}  // namespace tanor::detail
