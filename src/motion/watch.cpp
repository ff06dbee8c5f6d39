#include "motion/watch.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "base/text.hpp"
#include "motion/root_bracket.hpp"

namespace tanor {

namespace {

constexpr std::array<double, 5> places{0.0, 0.25, 0.5, 0.75, 1.0};

double sign_of(double value) {
  return value > 0.0 ? 1.0 : value < 0.0 ? -1.0 : 0.0;
}

}  // namespace

void Watch::add(Function function) {
  functions_.push_back(std::move(function));
  signs_.push_back(0.0);
  samples_.assign(places.size(), std::vector<double>(functions_.size()));
  for (std::vector<double>* array : {&x_, &v_}) array->resize(mechanics_.size());
  forget();
}

Outcome Watch::evaluate_inside(DenseOutput* output, double fraction, const State& from, const State& to) {
  const double t = fraction == 1.0 ? to.t : from.t + fraction * (to.t - from.t);
  if (fraction == 0.0 || fraction == 1.0) {
    x_ = fraction == 0.0 ? from.x : to.x;
    v_ = fraction == 0.0 ? from.v : to.v;
  } else if (Outcome found = output->evaluate(mechanics_.parallel(), fraction, x_.data(), v_.data()); !found.ok()) {
    return found;
  }
  mechanics_.prescribe(t, x_.data(), v_.data());
  return {};
}

Outcome Watch::report_not_finite(std::size_t k, double t) const {
  const std::string& name = functions_[k].name;
  return {Status::NotFinite,
          "event " + (name.empty() ? text(k) : "\"" + name + "\"") + " is not finite at t = " + text(t)};
}

/// Evaluates all functions at all places.
Outcome Watch::sample(DenseOutput* output, const State& from, const State& to) {
  for (std::size_t i = 0; i < places.size(); ++i) {
    if (Outcome found = evaluate_inside(output, places[i], from, to); !found.ok()) return found;
    const double t = output->time(places[i]);
    for (std::size_t k = 0; k < functions_.size(); ++k) {
      samples_[i][k] = functions_[k].value(t, x_.data(), v_.data());
      if (!std::isfinite(samples_[i][k])) return report_not_finite(k, t);
    }
  }
  return {};
}

bool Watch::changes_sign() const {
  for (std::size_t k = 0; k < functions_.size(); ++k) {
    for (const std::vector<double>& values : samples_) {
      if (values[k] * signs_[k] < 0.0) return true;
    }
  }
  return false;
}

/// Narrows a passage between the previous place and this one, where the value differs in sign from the one that was
/// kept.
Outcome Watch::narrow(DenseOutput* dense, const State& from, const State& to, std::size_t k, std::size_t place,
                      double sign, double* fraction) {
  const double before = sign * samples_[place - 1][k], after = sign * samples_[place][k];
  *fraction = places[place - 1];
  if (!(before > 0.0)) return {};
  constexpr double finest = 2.0 * std::numeric_limits<double>::epsilon();
  const double scale = std::max(1.0, std::abs(to.t) / (to.t - from.t));
  RootBracket bracket(places[place - 1], before, places[place], after, finest * scale);
  while (!bracket.is_narrow()) {
    const double s = bracket.next();
    if (s <= bracket.low() || s >= bracket.high()) break;
    if (Outcome found = evaluate_inside(dense, s, from, to); !found.ok()) return found;
    const double t = dense->time(s), value = functions_[k].value(t, x_.data(), v_.data());
    if (!std::isfinite(value)) return report_not_finite(k, t);
    bracket.narrow(s, sign * value);
  }
  *fraction = bracket.root();
  return {};
}

Outcome Watch::find_crossings(DenseOutput* dense, const State& from, const State& to) {
  for (std::size_t k = 0; k < functions_.size(); ++k) {
    double sign = signs_[k];
    for (std::size_t i = 1; i < places.size(); ++i) {
      const double now = sign_of(samples_[i][k]);
      if (now * sign < 0.0) {
        double fraction = 0.0;
        if (Outcome found = narrow(dense, from, to, k, i, sign, &fraction); !found.ok()) return found;
        const Event::Direction wanted = functions_[k].direction;
        const bool is_wanted = wanted == Event::Direction::Both || (wanted == Event::Direction::Rising) == (now > 0.0);
        pending_.push_back({{k, dense->time(fraction), now > 0.0}, is_wanted});
      }
      if (now != 0.0) sign = now;
    }
  }
  std::stable_sort(pending_.begin(), pending_.end(),
                   [](const Crossing& a, const Crossing& b) { return a.passage.time < b.passage.time; });
  return {};
}

Outcome Watch::look(const State& from, State* to, DenseOutput ends, DenseOutput dense, double* stop) {
  *stop = std::numeric_limits<double>::infinity();
  pending_.clear();
  if (Outcome found = sample(&ends, from, *to); !found.ok()) return found;
  if (!knows_signs_) {
    for (std::size_t k = 0; k < functions_.size(); ++k) signs_[k] = sign_of(samples_[0][k]);
    knows_signs_ = true;
  }
  // A function that began at 0 has a sign as soon as it leaves 0.
  for (std::size_t k = 0; k < functions_.size(); ++k) {
    for (std::size_t i = 1; signs_[k] == 0.0 && i < places.size(); ++i) signs_[k] = sign_of(samples_[i][k]);
  }
  const bool passes = changes_sign();
  if (passes) {
    Outcome found = sample(&dense, from, *to);
    if (found.ok()) found = find_crossings(&dense, from, *to);
    if (!found.ok()) return found;
  }
  for (std::size_t i = 0; i < pending_.size(); ++i) {
    if (!pending_[i].is_reported || !functions_[pending_[i].passage.event].stops) continue;
    *stop = pending_[i].passage.time;
    pending_.resize(i + 1);
  }
  mechanics_.prescribe(to->t, to->x.data(), to->v.data());
  // Variables other than positions change what they are converted with.
  if (!dense.has_moved() && mechanics_.keeps_variables()) return {};
  return mechanics_.accelerations(to->at(), options_.request(Gradients::Evaluate), to->output_without_power());
}

void Watch::accept() {
  for (const Crossing& crossing : pending_) {
    signs_[crossing.passage.event] = crossing.passage.rises ? 1.0 : -1.0;
    if (crossing.is_reported) passages_.push_back(crossing.passage);
  }
  pending_.clear();
}

}  // namespace tanor
