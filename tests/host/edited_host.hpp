#pragma once

#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include <tanor/constrainer.hpp>

/// \file A host whose rods come and go is compared with a new Constrainer for the present rods.
namespace tanor::host {

struct Edited {
  struct Rod {
    ConstraintId id;
    Index i, j;
    double length, rate = 0.0;
    bool has_rate = false;
  };
  std::vector<double> masses, r, v;
  std::vector<Rod> rods;  // by id
  Constrainer constrainer;
  std::mt19937 random;

  Edited(std::vector<double> m, std::vector<double> positions, const std::vector<std::array<Index, 2>>& pairs,
         unsigned seed, int threads = 1)
      : masses(std::move(m)),
        r(std::move(positions)),
        v(r.size()),
        constrainer(masses, {}, r, {.threads = threads}),
        random(seed) {
    std::vector<double> lengths;
    for (const auto& [i, j] : pairs) {
      rods.push_back({static_cast<ConstraintId>(rods.size()), i, j, distance(i, j)});
      lengths.push_back(rods.back().length);
    }
    constrainer.add(Rods{"rods", pairs, lengths, {}});
    std::normal_distribution<double> normal;
    for (double& x : v) x = normal(random);
  }

  std::size_t any(std::size_t count) { return std::uniform_int_distribution<std::size_t>(0, count - 1)(random); }
  double distance(Index i, Index j) const {
    double square = 0.0;
    for (std::size_t k = 0; k < 3; ++k) square += std::pow(at(r, j, k) - at(r, i, k), 2);
    return std::sqrt(square);
  }
  static double at(const std::vector<double>& x, Index i, std::size_t k) {
    return x[3 * static_cast<std::size_t>(i) + k];
  }

  // ---- edits ----

  void add(Index i, Index j) {
    const Rod rod{constrainer.add(Rods{{}, {{i, j}}, distance(i, j), {}}), i, j, distance(i, j)};
    rods.push_back(rod);
  }
  void remove(std::size_t k) {
    constrainer.remove({&rods[k].id, 1});
    rods.erase(rods.begin() + static_cast<std::ptrdiff_t>(k));
  }
  /// Changes a length by so little that the points may stay where they are.
  void set_length(std::size_t k, bool with_rate) {
    Rod& rod = rods[k];
    rod.length = distance(rod.i, rod.j) * (1.0 + 1e-10);
    rod.has_rate = rod.has_rate || with_rate;
    rod.rate = with_rate ? 1e-3 : 0.0;
    constrainer.set_lengths({&rod.id, 1}, {&rod.length, 1}, {&rod.rate, 1});
  }
  void set_mass(Index point, double mass) {
    masses[static_cast<std::size_t>(point)] = mass;
    constrainer.set_masses({&point, 1}, {&mass, 1});
  }
  /// Makes a random edit at points whose numbers are close.
  void edit() {
    const std::size_t n = masses.size();
    const std::size_t choice = any(8);
    if (choice < 3 && rods.size() > n / 2) return remove(any(rods.size()));
    if (choice < 6) {
      const auto i = static_cast<Index>(any(n));
      const auto j = static_cast<Index>((static_cast<std::size_t>(i) + 1 + any(4)) % n);
      const auto joins = [&](const Rod& rod) { return std::minmax(rod.i, rod.j) == std::minmax(i, j); };
      if (std::ranges::none_of(rods, joins)) return add(i, j);
    }
    if (choice == 6 && !rods.empty()) return set_length(any(rods.size()), any(3) == 0);
    const std::size_t point = any(n);
    if (std::isfinite(masses[point])) set_mass(static_cast<Index>(point), 0.5 + 0.25 * static_cast<double>(any(8)));
  }

  // ---- beside a new one ----

  Constrainer make_fresh(int threads = 1) const {
    Rods all{"others", {}, {}, {}};
    std::vector<double> lengths;
    for (const Rod& rod : rods) {
      all.pairs.push_back({rod.i, rod.j});
      lengths.push_back(rod.length);
    }
    all.length = lengths;
    Constrainer fresh(masses, {all}, r, {.threads = threads});
    for (std::size_t k = 0; k < rods.size(); ++k) {
      const auto id = static_cast<ConstraintId>(k);
      const double moving = 1.0;
      if (!rods[k].has_rate) continue;
      fresh.set_lengths({&id, 1}, {&rods[k].length, 1}, {&moving, 1});
      fresh.set_lengths({&id, 1}, {&rods[k].length, 1}, {&rods[k].rate, 1});
    }
    return fresh;
  }

  struct Result {
    std::vector<double> r, v, lambda;
    Status positions = Status::Ok, velocities = Status::Ok;
    int iterations = 0;

    friend bool operator==(const Result&, const Result&) = default;
  };
  /// Takes a step from the host's state and leaves that state as it is.
  Result step(Constrainer* by, double h) const {
    Result result{r, v, std::vector<double>(rods.size())};
    ConstraintReport report = by->constrain_velocities({.positions = result.r, .velocities = result.v});
    result.velocities = report.outcome.status;
    for (std::size_t k = 0; k < r.size(); ++k) {
      if (std::isfinite(masses[k / 3])) result.r[k] += h * result.v[k];
    }
    report = by->constrain_positions({.step = h,
                                      .old_positions = r,
                                      .positions = result.r,
                                      .velocities = result.v,
                                      .wanted = {.multipliers = result.lambda}});
    result.positions = report.outcome.status;
    result.iterations = report.iterations;
    return result;
  }
  void go_to(const Result& result) {
    r = result.r;
    v = result.v;
  }
};

/// Appends zigzag chains of points, one after the other, and returns the pairs of their rods.
inline std::vector<std::array<Index, 2>> make_chains(std::size_t count, std::size_t length, std::vector<double>* r) {
  std::vector<std::array<Index, 2>> pairs;
  for (std::size_t c = 0; c < count; ++c) {
    for (std::size_t k = 0; k < length; ++k) {
      const auto point = static_cast<Index>(r->size() / 3);
      const auto x = static_cast<double>(k), y = static_cast<double>(c);
      r->insert(r->end(), {0.9 * x, 3.0 * y + 0.4 * std::sin(2.1 * x + y), 0.3 * std::cos(1.3 * x * x + y)});
      if (k > 0) pairs.push_back({point - 1, point});
    }
  }
  return pairs;
}

/// Appends square nets, bent so that they are not flat, and returns the pairs of their rods.
inline std::vector<std::array<Index, 2>> make_nets(std::size_t count, std::size_t side, std::vector<double>* r) {
  std::vector<std::array<Index, 2>> pairs;
  for (std::size_t c = 0; c < count; ++c) {
    for (std::size_t a = 0; a < side; ++a) {
      for (std::size_t b = 0; b < side; ++b) {
        const auto point = static_cast<Index>(r->size() / 3);
        const auto x = static_cast<double>(a), y = static_cast<double>(b);
        r->insert(r->end(), {x, y + 2.0 * static_cast<double>(c * side), 0.3 * std::sin(1.7 * x + 2.3 * y)});
        if (b > 0) pairs.push_back({point - 1, point});
        if (a > 0) pairs.push_back({point - static_cast<Index>(side), point});
      }
    }
  }
  return pairs;
}

}  // namespace tanor::host
