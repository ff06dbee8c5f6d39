#include "embed/ranks/island_exchange.hpp"

#include <algorithm>
#include <numeric>

namespace tanor::embed {

IslandExchange::IslandExchange(MPI_Comm world) : world_(world) {
  MPI_Comm_rank(world_, &rank_);
  MPI_Comm_size(world_, &num_ranks_);
}

void IslandExchange::assign(std::span<const Bond> bonds, std::span<const int> home) {
  // The root of an island is its lowest tag.
  std::vector<int> root(home.size());
  std::iota(root.begin(), root.end(), 0);
  const auto find = [&](int tag) {
    while (root[tag] != tag) tag = root[tag] = root[root[tag]];
    return tag;
  };
  for (const Bond& bond : bonds) {
    const int a = find(bond.a), b = find(bond.b);
    root[std::max(a, b)] = std::min(a, b);
  }
  owners_.assign(home.size(), -1);
  points_.assign(home.size(), -1);
  for (const Bond& bond : bonds)
    for (const int tag : {bond.a, bond.b}) owners_[tag] = home[find(tag)];
  tags_.clear();
  num_islands_ = 0;
  for (std::size_t tag = 0; tag < owners_.size(); ++tag)
    if (owners_[tag] == rank_) {
      num_islands_ += find(static_cast<int>(tag)) == static_cast<int>(tag) ? 1 : 0;
      points_[tag] = static_cast<int>(tags_.size());
      tags_.push_back(static_cast<int>(tag));
    }
}

std::string IslandExchange::list(std::span<const int> tags) {
  const std::size_t num_ranks = static_cast<std::size_t>(num_ranks_);
  const auto owner = [&](int tag) { return tag < static_cast<int>(owners_.size()) ? owners_[tag] : -1; };
  const auto sum_up = [](Side* side) {
    side->starts.assign(side->counts.size() + 1, 0);
    std::partial_sum(side->counts.begin(), side->counts.end(), side->starts.begin() + 1);
    side->items.resize(side->starts.back());
    side->numbers.resize(most_numbers * side->items.size());
  };
  senders_.counts.assign(num_ranks, 0);
  for (const int tag : tags)
    if (owner(tag) >= 0) ++senders_.counts[owner(tag)];
  sum_up(&senders_);
  std::vector<int> next(senders_.starts.begin(), senders_.starts.end() - 1), sent(senders_.items.size());
  for (std::size_t i = 0; i < tags.size(); ++i)
    if (const int to = owner(tags[i]); to >= 0) {
      sent[next[to]] = tags[i];
      senders_.items[next[to]++] = static_cast<int>(i);
    }

  receivers_.counts.resize(num_ranks);
  MPI_Alltoall(senders_.counts.data(), 1, MPI_INT, receivers_.counts.data(), 1, MPI_INT, world_);
  sum_up(&receivers_);
  MPI_Alltoallv(sent.data(), senders_.counts.data(), senders_.starts.data(), MPI_INT, receivers_.items.data(),
                receivers_.counts.data(), receivers_.starts.data(), MPI_INT, world_);
  for (int& item : receivers_.items) item = points_[item];
  std::string lost = agree(find_lost());
  if (!lost.empty() || num_ranks_ > 1) return lost;
  // A single rank visits its points in their order.
  std::vector<int> atoms(receivers_.items.size());
  for (std::size_t k = 0; k < atoms.size(); ++k) atoms[receivers_.items[k]] = senders_.items[k];
  senders_.items = std::move(atoms);
  std::iota(receivers_.items.begin(), receivers_.items.end(), 0);
  return {};
}

std::string IslandExchange::find_lost() const {
  std::vector<bool> came(tags_.size(), false);
  for (const int point : receivers_.items) {
    if (came[point]) return "atom " + std::to_string(tags_[point]) + " is there twice";
    came[point] = true;
  }
  const auto first = std::find(came.begin(), came.end(), false);
  if (first == came.end()) return {};
  return "atom " + std::to_string(tags_[first - came.begin()]) + ", which a bond holds, was lost";
}

void IslandExchange::exchange(int width, const Side& from, Side* to) {
  const Side* const sides[] = {&from, to};
  for (int k = 0; k < 2; ++k) {
    counts_[k].resize(num_ranks_);
    starts_[k].resize(num_ranks_);
    for (int p = 0; p < num_ranks_; ++p) {
      counts_[k][p] = width * sides[k]->counts[p];
      starts_[k][p] = width * sides[k]->starts[p];
    }
  }
  MPI_Alltoallv(from.numbers.data(), counts_[0].data(), starts_[0].data(), MPI_DOUBLE, to->numbers.data(),
                counts_[1].data(), starts_[1].data(), MPI_DOUBLE, world_);
}

std::string IslandExchange::agree(const std::string& trouble) const {
  if (num_ranks_ == 1) return trouble;
  const int mine = trouble.empty() ? num_ranks_ : rank_;
  int first = num_ranks_;
  MPI_Allreduce(&mine, &first, 1, MPI_INT, MPI_MIN, world_);
  if (first == num_ranks_) return {};
  std::string said = trouble;
  int size = static_cast<int>(said.size());
  MPI_Bcast(&size, 1, MPI_INT, first, world_);
  said.resize(size);
  MPI_Bcast(said.data(), size, MPI_CHAR, first, world_);
  return said;
}

}  // namespace tanor::embed
