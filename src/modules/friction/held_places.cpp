#include "friction/held_places.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "base/numbers.hpp"

namespace tanor::detail {

namespace {

bool do_guides_rest(const Workspace& work) {
  const Tangents& tangents = work.constraints.tangents();
  bool rest = !work.constraints.depends_on_time() && !tangents.depends_on_time();
  for (std::size_t c = 0; c < tangents.size(); ++c) rest = rest && norm(tangents.own_velocity(c).value) == 0.0;
  return rest;
}

}  // namespace

HeldPlaces::HeldPlaces(Workspace& work)
    : work_(work),
      tangents_(work.constraints.tangents()),
      guides_rest_(do_guides_rest(work)),
      is_held_(tangents_.size(), 0),
      then_{work.time(), std::vector<Vec3>(tangents_.size()), std::vector<Vec3>(tangents_.size())},
      now_(then_) {}

void HeldPlaces::hold(double t, const double* r) {
  carry(t);
  for (std::size_t c = 0; c < tangents_.size(); ++c) {
    if (tangents_.sticks(c) && !holds(c)) {
      now_.places[c] = load(r, tangents_[c].point);
      now_.rest[c] = {};
    }
    is_held_[c] = tangents_.sticks(c) ? 1 : 0;
  }
  list_held();
  accept(t);
  publish();
}

void HeldPlaces::forget() {
  std::fill(is_held_.begin(), is_held_.end(), 0);
  list_held();
  publish();
}

void HeldPlaces::accept(double t) {
  carry(t);
  then_ = now_;
}

void HeldPlaces::give_way(const double* r) {
  constexpr double given_way = 1e-12;
  for (const std::size_t c : held_) {
    if (!tangents_.sticks(c)) continue;
    const Vec3 away = load(r, tangents_[c].point) - now_.places[c];
    double along = 0.0;
    for (int k = 0; k < tangents_[c].num_tangents(); ++k)
      along = std::max(along, std::abs(dot(tangents_.directions(c)[static_cast<std::size_t>(k)], away)));
    if (along <= given_way * length_around(c)) continue;
    now_.places[c] = then_.places[c] = load(r, tangents_[c].point);
    now_.rest[c] = then_.rest[c] = {};
    publish();
  }
}

double HeldPlaces::largest_violation(const double* rows, const Dependences& redundancy) const {
  double worst = 0.0;
  for (const std::size_t c : held_) {
    if (!tangents_.sticks(c)) continue;
    const double length = length_around(c);
    for (int k = 0; k < tangents_[c].num_tangents(); ++k) {
      const auto row = static_cast<std::size_t>(tangents_[c].first_row + k);
      if (!redundancy.is_dependent(row)) worst = larger(worst, std::abs(rows[row]) / length);
    }
  }
  return worst;
}

void HeldPlaces::list_held() {
  held_.clear();
  for (std::size_t c = 0; c < tangents_.size(); ++c) {
    if (holds(c)) held_.push_back(c);
  }
  guides_.reset();
}

/// Passes the places to the rows of the contacts.
void HeldPlaces::publish() {
  for (std::size_t c = 0; c < tangents_.size(); ++c) tangents_.set_place(c, holds(c), now_.places[c]);
}

void HeldPlaces::carry(double t) {
  if (t == now_.time) return;
  now_.time = t;
  if (guides_rest_ || held_.empty()) return;
  start_.clear();
  for (const std::size_t c : held_) start_.push_back(then_.places[c]);
  advance(then_.time, t);
  // The sums of many steps are compensated (Kahan).
  places_.resize(held_.size());
  for (std::size_t k = 0; k < held_.size(); ++k) {
    const std::size_t c = held_[k];
    const Vec3 then = then_.places[c], way = ways_[k] - then_.rest[c];
    places_[k] = then + way;
    now_.rest[c] = (places_[k] - then) - way;
  }
  // An error across the guide, even of rounding size, would make them drift along it.
  for (int pass = 0; pass < 2; ++pass) {
    evaluate_guides(t, places_, false);
    for (std::size_t k = 0; k < held_.size(); ++k) places_[k] = places_[k] - across(held_[k], {});
  }
  for (std::size_t k = 0; k < held_.size(); ++k) now_.places[held_[k]] = places_[k];
  publish();
}

void HeldPlaces::exchange_memory(Memory& memory) {
  memory.exchange(then_.time);
  for (std::size_t c = 0; c < tangents_.size(); ++c) memory.exchange(is_held_[c], then_.places[c], then_.rest[c]);
  if (!memory.reads()) return;
  now_ = then_;
  list_held();
  publish();
}

// ---- the motion of places with their guides ----

double HeldPlaces::length_around(std::size_t contact) const {
  return work_.scales.length(work_.scales.of_point(static_cast<std::size_t>(tangents_[contact].point)));
}

/// Finds the displacements `ways_` of the places until t, which are at `start_` at the time `from`.
void HeldPlaces::advance(double from, double t) {
  constexpr int most_halvings = 6;  // a spline's knot needs them; the error left after them is small
  ways_.assign(held_.size(), Vec3{});
  double reached = from, h = t - reached;
  for (int halvings = 0; reached != t;) {
    const bool is_last = std::abs(h) >= std::abs(t - reached);
    if (is_last) h = t - reached;
    if (!extrapolate(reached, h, ways_, &next_) && halvings < most_halvings) {
      ++halvings;
      h *= 0.5;
      continue;
    }
    std::swap(ways_, next_);
    reached = is_last ? t : reached + h;
  }
}

/// Makes one step of Gragg, Bulirsch and Stoer: the midpoint rule with 2, 4, 6, … pieces, extrapolated in the square of
/// their length until changes are rounding, including that of the time. Returns false if it does not converge.
bool HeldPlaces::extrapolate(double t, double h, const Places& from, Places* ways) {
  for (int j = 0; j < static_cast<int>(most_columns); ++j) {
    Places& next = *ways;
    advance_by_midpoints(t, h, 2 * (j + 1), from, &next);
    double worst = std::numeric_limits<double>::infinity();
    // T_{j,k} = T_{j,k-1} + (T_{j,k-1} - T_{j-1,k-1})/((n_j/n_{j-k})^2 - 1)
    for (int k = 1; k <= j; ++k) {
      const double ratio = static_cast<double>(j + 1) / (j + 1 - k), part = 1.0 / (ratio * ratio - 1.0);
      Places& before = table_[static_cast<std::size_t>(k - 1)];
      worst = 0.0;
      for (std::size_t i = 0; i < next.size(); ++i) {
        const Vec3 change = part * (next[i] - before[i]), better = next[i] + change;
        const double length = length_around(held_[i]);
        const double way_of_time = std::abs(t / h) * norm(better - from[i]);
        const double scale = std::max({norm(better - from[i]), length, way_of_time});
        worst = larger(worst, norm(change) / scale);
        before[i] = next[i];
        next[i] = better;
      }
    }
    table_[static_cast<std::size_t>(j)] = next;
    if (worst <= 4.0 * eps) return true;
  }
  return false;
}

void HeldPlaces::advance_by_midpoints(double t, double h, int count, const Places& from, Places* to) {
  const double step = h / count;
  Places &now = *to, &before = before_, &rates = rates_;
  before = from;
  rates.resize(from.size());
  now.resize(from.size());
  evaluate(t, from, &rates);
  for (std::size_t k = 0; k < from.size(); ++k) now[k] = from[k] + step * rates[k];
  for (int m = 1; m < count; ++m) {
    evaluate(t + m * step, now, &rates);
    for (std::size_t k = 0; k < from.size(); ++k) {
      const Vec3 next = before[k] + 2.0 * step * rates[k];
      before[k] = now[k];
      now[k] = next;
    }
  }
}

/// Computes p_dot at the displacements `ways` from the start.
void HeldPlaces::evaluate(double t, const Places& ways, Places* rates) {
  places_.resize(ways.size());
  for (std::size_t k = 0; k < ways.size(); ++k) places_[k] = start_[k] + ways[k];
  evaluate_guides(t, places_, true);
  for (std::size_t k = 0; k < ways.size(); ++k) {
    const Vec3 u = tangents_.own_velocity(held_[k]).value;
    (*rates)[k] = u - across(held_[k], u);
  }
}

/// Evaluates K_g of the contacts' guides at (t, places), and their xi_t or xi.
void HeldPlaces::evaluate_guides(double t, const Places& places, bool wants_rates) {
  if (!guides_) select_guides();
  work_.set_time(t);
  for (std::size_t k = 0; k < places.size(); ++k) store(points_.data(), tangents_[held_[k]].point, places[k]);
  const Constraints& constraints = work_.constraints;
  const Parallel& parallel = work_.model().parallel;
  const double* const points = points_.data();
  constraints.evaluate_gradients(parallel, *guides_, points, blocks_.data());
  if (wants_rates)
    (void)constraints.evaluate_rates(parallel, *guides_, points, at_rest_.data(), rows_.data());
  else
    (void)constraints.evaluate_values(parallel, *guides_, points, rows_.data());
}

void HeldPlaces::select_guides() {
  const Constraints& constraints = work_.constraints;
  std::vector<char> takes_part(work_.model().num_rows(), 0);
  for (const std::size_t c : held_) {
    for (int g = 0; g < tangents_[c].num_guides; ++g)
      takes_part[static_cast<std::size_t>(tangents_[c].guide_row[static_cast<std::size_t>(g)])] = 1;
  }
  guides_ = constraints.select(takes_part);
  for (std::vector<double>* array : {&points_, &at_rest_}) array->resize(3 * work_.model().num_points(), 0.0);
  rows_.resize(work_.model().num_rows());
  blocks_.resize(3 * constraints.num_blocks());
}

/// Returns K_g Gamma_g^-1 (K_g'u + rows), Gamma_g = K_g'K_g, with the last K_g and rows.
Vec3 HeldPlaces::across(std::size_t contact, const Vec3& u) const {
  const Tangents::Place& place = tangents_[contact];
  const Vec3 a = load(blocks_.data(), place.guide_block[0]);
  const double in_a = dot(a, u) + rows_[static_cast<std::size_t>(place.guide_row[0])], aa = dot(a, a);
  if (place.num_guides == 1) return (in_a / aa) * a;
  const Vec3 b = load(blocks_.data(), place.guide_block[1]);
  const double in_b = dot(b, u) + rows_[static_cast<std::size_t>(place.guide_row[1])];
  const double ab = dot(a, b), bb = dot(b, b), determinant = aa * bb - ab * ab;
  return ((bb * in_a - ab * in_b) / determinant) * a + ((aa * in_b - ab * in_a) / determinant) * b;
}

}  // namespace tanor::detail
