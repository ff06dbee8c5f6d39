#include "ranks/halo.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <set>
#include <utility>

#include "evaluate/neighbours.hpp"

namespace tanor::detail {

Halo::Halo(Ranks& ranks, const PeriodicBox& box, double cutoff, std::span<const Index> numbers)
    : ranks_(ranks),
      box_(box),
      cutoff_(cutoff),
      own_numbers_(numbers.begin(), numbers.end()),
      share_(Decisions(&ranks).share(numbers.size())),
      start_(numbers.size() + 1, 0) {}

double Halo::largest_move(std::span<const Vec3> own) const {
  double worst = 0.0;
  for (std::size_t i = 0; i < own.size(); ++i) worst = larger(worst, squared(own[i] - made_at_[i]));
  return std::sqrt(worst);
}

void Halo::make(std::span<const Vec3> own, double skin) {
  skin_ = skin;
  made_at_.assign(own.begin(), own.end());
  const std::size_t num_all = share_.all(), first_own = share_.first;
  std::vector<double> all(4 * num_all, 0.0);  // places and numbers
  for (std::size_t i = 0; i < own.size(); ++i) {
    double* const here = &all[4 * (first_own + i)];
    store(here, 0, own[i]);
    here[3] = static_cast<double>(own_numbers_[i]);
  }
  ranks_.sum(all);
  // Own points come first, as those that move. The others count as supports, which are no pairs of each other.
  std::vector<Vec3> places(own.begin(), own.end());
  std::vector<std::size_t> others;  // numbers among those of all ranks
  for (std::size_t k = 0; k < num_all; ++k) {
    if (k >= first_own && k < first_own + own.size()) continue;
    others.push_back(k);
    places.push_back(load(&all[4 * k], 0));
  }
  const Parallel one_thread(1);
  NeighbourLists lists(cutoff_, skin, box_, own.size(), Groups<Index>(places.size(), [](const auto&) {}));
  if (!places.empty()) lists.make(one_thread, places, skin);
  numbers_.clear();
  near_.clear();
  std::vector<Index> in_halo(others.size(), -1);
  std::map<int, std::pair<std::vector<Index>, std::set<Index>>> links;  // [rank] points received, and those sent
  lists.for_each_point(one_thread, [&](std::size_t i, std::span<const Index> neighbours) {
    if (i < own.size() || neighbours.empty()) return;
    const std::size_t other = others[i - own.size()];
    const auto rank = static_cast<int>(std::ranges::upper_bound(share_.start, other) - share_.start.begin()) - 1;
    auto& [received, sent] = links[rank];
    sent.insert(neighbours.begin(), neighbours.end());
    received.push_back(in_halo[i - own.size()] = static_cast<Index>(numbers_.size()));
    numbers_.push_back(static_cast<Index>(all[4 * other + 3]));
  });
  lists.for_each_point(one_thread, [&](std::size_t i, std::span<const Index> neighbours) {
    if (i >= own.size()) return;
    for (const Index j : neighbours)
      if (static_cast<std::size_t>(j) >= own.size()) near_.push_back(in_halo[static_cast<std::size_t>(j) - own.size()]);
    start_[i + 1] = near_.size();
  });
  // The lists of two ranks name the same points in the same order, since distances are the same from both sides, bit by
  // bit.
  std::vector<Part::Link> found;
  for (auto& [rank, link] : links)
    found.push_back({rank, {link.second.begin(), link.second.end()}, std::move(link.first)});
  exchange_.emplace(ranks_, std::move(found));
}

void Halo::fetch(std::span<const Vec3> own, std::vector<Vec3>* places) {
  places->resize(size());
  exchange_->fetch([&](Index i) { return own[static_cast<std::size_t>(i)]; },
                   [&](Index i, const Vec3& place) { (*places)[static_cast<std::size_t>(i)] = place; });
}

}  // namespace tanor::detail
