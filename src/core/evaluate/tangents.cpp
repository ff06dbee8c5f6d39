#include "evaluate/tangents.hpp"

#include <algorithm>
#include <cmath>
#include <variant>

#include "evaluate/charts.hpp"

namespace tanor::detail {

namespace {

Vec3 unit(const Vec3& a) {
  return (1.0 / norm(a)) * a;
}

const VectorFunction& velocity_of(const Friction& friction) {
  return std::visit([](const auto& entry) -> const VectorFunction& { return entry.velocity; }, friction);
}

/// Writes value(contact, k) of each direction of the contacts that have rows; returns the largest.
template <class Value>
double write_rows(const Tangents& tangents, double* rows, const Value& value) {
  double worst = 0.0;
  for (std::size_t c = 0; c < tangents.size(); ++c) {
    for (int k = 0; tangents[c].first_row >= 0 && k < tangents[c].num_tangents(); ++k) {
      double& row = rows[tangents[c].first_row + k];
      row = value(c, static_cast<std::size_t>(k));
      worst = larger(worst, std::abs(row));
    }
  }
  return worst;
}

}  // namespace

Tangents::Tangents(const System& system, const Numbering& numbering, std::span<const Incidence> incidences,
                   Index first_block) {
  const std::vector<Contact> contacts = list_contacts(system);
  if (contacts.empty()) return;
  std::vector<Index> inner_row(numbering.num_rows()), block_of_row(numbering.num_rows(), -1);
  for (std::size_t a = 0; a < inner_row.size(); ++a)
    inner_row[static_cast<std::size_t>(numbering.user_row[a])] = static_cast<Index>(a);
  for (const Incidence& incidence : incidences) block_of_row[static_cast<std::size_t>(incidence.row)] = incidence.block;
  std::vector<std::size_t> slots;
  for (const Friction& friction : system.friction) slots.push_back(velocities_.add(velocity_of(friction)));

  auto own_row = static_cast<Index>(numbering.num_user_rows);
  for (const Contact& contact : contacts) {
    Place place{contact.friction,
                numbering.inner_point[static_cast<std::size_t>(contact.point)],
                static_cast<int>(contact.guide_rows.size()),
                {-1, -1},
                {-1, -1}};
    for (std::size_t k = 0; k < contact.guide_rows.size(); ++k) {
      place.guide_row[k] = inner_row[static_cast<std::size_t>(contact.guide_rows[k])];
      place.guide_block[k] = block_of_row[static_cast<std::size_t>(place.guide_row[k])];
    }
    const auto one_sided = std::ranges::lower_bound(numbering.one_sided, place.guide_row[0], {}, &OneSidedRow::row);
    if (one_sided != numbering.one_sided.end() && one_sided->row == place.guide_row[0])
      place.side = one_sided->sign > 0.0 ? 1 : -1;
    place.velocity = slots[static_cast<std::size_t>(contact.friction)];
    if (contact.can_stick) {
      place.first_row = inner_row[static_cast<std::size_t>(own_row)];
      place.first_block = first_block + static_cast<Index>(num_blocks_);
      own_row += place.num_tangents();
      num_blocks_ += static_cast<std::size_t>(place.num_tangents());
    }
    places_.push_back(place);
  }
  sticks_.assign(size(), 0);
  normals_.resize(size());
  directions_.resize(size());
  places_held_.resize(size());
}

void Tangents::write_gradients(const Parallel& parallel, double* blocks) {
  parallel.for_ranges(size(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t c = begin; c < end; ++c) {
      const Place& place = places_[c];
      auto& [t, s] = directions_[c];
      auto& [k, l] = normals_[c];
      k = load(blocks, place.guide_block[0]);
      if (is_open(c)) {
        t = s = l = {};
      } else if (place.num_guides == 2) {
        l = load(blocks, place.guide_block[1]);
        t = unit(cross(k, l));
        s = {};
      } else {
        l = {};
        // t is the projection of the axis that the normal is farthest from.
        s = any_orthogonal(unit(k));
        t = cross(s, unit(k));
      }
      if (place.first_row < 0) continue;
      for (int m = 0; m < place.num_tangents(); ++m)
        store(blocks, place.first_block + m, sticks(c) ? directions_[c][static_cast<std::size_t>(m)] : Vec3{});
    }
  });
}

std::size_t Tangents::find_undirected() const {
  constexpr double parallel = 1e-10;  // T has no more digits than the sine of the angle leaves
  for (std::size_t c = 0; c < size(); ++c) {
    const auto& [k, l] = normals_[c];
    const double sizes = places_[c].num_guides == 2 ? norm(k) * norm(l) : norm(k);
    const double across = places_[c].num_guides == 2 ? norm(cross(k, l)) : sizes;
    if (!is_open(c) && !(across > parallel * sizes)) return c;
  }
  return size();
}

std::size_t Tangents::num_sticking() const {
  return static_cast<std::size_t>(std::count_if(sticks_.begin(), sticks_.end(), [](char each) { return each != 0; }));
}

Vec3 Tangents::sliding_velocity(std::size_t contact, const double* v) const {
  const Vec3 relative = load(v, places_[contact].point) - velocities_[places_[contact].velocity].value;
  const auto& [t, s] = directions_[contact];
  return dot(t, relative) * t + dot(s, relative) * s;
}

void Tangents::write_values(const double* r, double* xi) const {
  (void)write_rows(*this, xi, [&](std::size_t c, std::size_t k) {
    const bool is_held = places_held_[c].first && sticks(c);
    return is_held ? dot(directions_[c][k], load(r, places_[c].point) - places_held_[c].second) : 0.0;
  });
}

double Tangents::evaluate_rates(const double* v, double* rate) const {
  return write_rows(*this, rate, [&](std::size_t c, std::size_t k) {
    return sticks(c) ? dot(directions_[c][k], load(v, places_[c].point) - own_velocity(c).value) : 0.0;
  });
}

double Tangents::apply_transposed(const double* blocks, const double* x, const double* shift, double* y) const {
  return write_rows(*this, y, [&](std::size_t c, std::size_t k) {
    const auto own = static_cast<Index>(k);
    return dot(load(blocks, places_[c].first_block + own), load(x, places_[c].point)) +
           (shift != nullptr ? shift[places_[c].first_row + own] : 0.0);
  });
}

// ---- the acceleration level ----

std::array<double, 2> Tangents::across(std::size_t contact, const double* v) const {
  if (is_open(contact)) return {};
  const Place& place = places_[contact];
  const Vec3 relative = load(v, place.point) - velocities_[place.velocity].value;
  const auto& [k, l] = normals_[contact];
  const double kk = dot(k, k), b = dot(k, relative);
  if (place.num_guides == 1) return {b / kk, 0.0};
  // c solves Gamma_g c = K_g'(v - u), 2 x 2.
  const double kl = dot(k, l), ll = dot(l, l), d = dot(l, relative), determinant = kk * ll - kl * kl;
  return {(ll * b - kl * d) / determinant, (kk * d - kl * b) / determinant};
}

int Tangents::num_turning(const double* v, Which which) const {
  int most = 0;
  for (std::size_t c = 0; c < size(); ++c) {
    const Place& place = places_[c];
    const bool counts = place.first_row >= 0 && (sticks(c) || which == Which::All);
    if (counts && place.num_tangents() > most && across(c, v) != std::array{0.0, 0.0}) most = place.num_tangents();
  }
  return most;
}

void Tangents::shift_velocities(int k, double s, const double* v, double* shifted) const {
  for (std::size_t c = 0; c < size(); ++c) {
    const Index point = places_[c].point;
    store(shifted, point, load(v, point) + s * directions_[c][static_cast<std::size_t>(k)]);
  }
}

double Tangents::evaluate_right_side(const double* v, const double* w0, const std::array<const double*, 2>& turn,
                                     Which which, double* phi) const {
  return write_rows(*this, phi, [&](std::size_t c, std::size_t m) {
    if (is_open(c) || (!sticks(c) && which != Which::All)) return 0.0;
    // The value is T'w0 - T'u_dot - T'K_g_dot c.
    const Place& place = places_[c];
    double value = dot(directions_[c][m], load(w0, place.point) - own_velocity(c).first);
    if (turn[m] == nullptr) return value;
    const std::array<double, 2> coefficients = across(c, v);
    for (std::size_t g = 0; g < static_cast<std::size_t>(place.num_guides); ++g)
      value -= turn[m][place.guide_row[g]] * coefficients[g];
    return value;
  });
}

}  // namespace tanor::detail
