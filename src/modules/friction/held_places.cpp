#include "friction/held_places.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/numbers.hpp"

namespace tanor::detail {

HeldPlaces::HeldPlaces(Workspace& work)
    : tangents_(work.constraints.tangents()),
      motion_(work),
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
  for (const std::size_t c : held()) {
    if (!tangents_.sticks(c)) continue;
    const Vec3 away = load(r, tangents_[c].point) - now_.places[c];
    double along = 0.0;
    for (int k = 0; k < tangents_[c].num_tangents(); ++k)
      along = std::max(along, std::abs(dot(tangents_.directions(c)[static_cast<std::size_t>(k)], away)));
    if (along <= given_way * motion_.length_around(c)) continue;
    now_.places[c] = then_.places[c] = load(r, tangents_[c].point);
    now_.rest[c] = then_.rest[c] = {};
    publish();
  }
}

double HeldPlaces::largest_violation(const double* rows, const Dependences& redundancy) const {
  double worst = 0.0;
  for (const std::size_t c : held()) {
    if (!tangents_.sticks(c)) continue;
    const double length = motion_.length_around(c);
    for (int k = 0; k < tangents_[c].num_tangents(); ++k) {
      const auto row = static_cast<std::size_t>(tangents_[c].first_row + k);
      if (!redundancy.is_dependent(row)) worst = larger(worst, std::abs(rows[row]) / length);
    }
  }
  return worst;
}

void HeldPlaces::list_held() {
  std::vector<std::size_t> held;
  for (std::size_t c = 0; c < tangents_.size(); ++c) {
    if (holds(c)) held.push_back(c);
  }
  motion_.select(std::move(held));
}

/// Passes the places to the rows of the contacts.
void HeldPlaces::publish() {
  for (std::size_t c = 0; c < tangents_.size(); ++c) tangents_.set_place(c, holds(c), now_.places[c]);
}

void HeldPlaces::carry(double t) {
  if (t == now_.time) return;
  now_.time = t;
  if (motion_.guides_rest() || held().empty()) return;
  GuideMotion::Places& places = on_guides_;
  places.clear();
  for (const std::size_t c : held()) places.push_back(then_.places[c]);
  const GuideMotion::Places& ways = motion_.advance(places, then_.time, t);
  // The sums of many steps are compensated (Kahan).
  for (std::size_t k = 0; k < ways.size(); ++k) {
    const std::size_t c = held()[k];
    const Vec3 then = then_.places[c], way = ways[k] - then_.rest[c];
    places[k] = then + way;
    now_.rest[c] = (places[k] - then) - way;
  }
  motion_.put_on_guides(t, &places);
  for (std::size_t k = 0; k < places.size(); ++k) now_.places[held()[k]] = places[k];
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

}  // namespace tanor::detail
