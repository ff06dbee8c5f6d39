#pragma once

#include <mpi.h>

#include <array>
#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "embed/ranks/atoms.hpp"

namespace tanor::embed {

/// Gives every island of bonded atoms to one rank, its owner, and carries numbers of atoms to the owners and back, with
/// one MPI_Alltoallv each way. Owners stay the same until the next `assign`, however far atoms migrate, so that what an
/// owner has planned for its islands stays valid. Only the lists of who sends what follow the atoms.
class IslandExchange {
 public:
  explicit IslandExchange(MPI_Comm world);

  MPI_Comm world() const { return world_; }
  int rank() const { return rank_; }
  int num_ranks() const { return num_ranks_; }

  /// Assigns each island to the rank that has its lowest tag. `bonds` are the same on every rank, and so is `home`:
  /// [tag] the rank that has the atom, -1 if no rank has it.
  void assign(std::span<const Bond> bonds, std::span<const int> home);
  /// Lists the atoms anew, whenever those of a rank, or their order, have changed. Returns what is wrong, on every
  /// rank. Collective.
  std::string list(std::span<const int> tags);

  /// Returns the number of points that this rank owns, which are in the order of their tags.
  std::size_t num_points() const { return tags_.size(); }
  std::size_t num_islands() const { return num_islands_; }
  /// Returns the point of an atom, or -1 if it is another rank's, or in no island.
  int point(int tag) const { return points_[static_cast<std::size_t>(tag)]; }
  /// Returns [point] its atom if there is one rank, else null.
  const int* atom_of_point() const { return num_ranks_ == 1 ? senders_.items.data() : nullptr; }

  /// Calls read(atom of this rank, numbers) on the rank that has the atom, and write(point, numbers) on its owner.
  /// Atoms do not stand in the order of points, so fetch(atom) prefetches what will be read. Collective.
  template <int width, class Fetch, class Read, class Write>
  void to_owners(const Fetch& fetch, const Read& read, const Write& write) {
    carry<width>(senders_, receivers_, read, write,
                 [&](const Side& from, const Side&, std::size_t k) { fetch(from.items[k]); });
  }
  /// Calls read(point, numbers) on the owner, and write(atom of this rank, numbers) on the rank that has it.
  /// Collective.
  template <int width, class Fetch, class Read, class Write>
  void from_owners(const Fetch& fetch, const Read& read, const Write& write) {
    carry<width>(receivers_, senders_, read, write,
                 [&](const Side&, const Side& to, std::size_t k) { fetch(to.items[k]); });
  }

  /// Returns on every rank the text of the first rank that has one, or an empty text. Collective.
  std::string agree(const std::string& trouble) const;

 private:
  static constexpr int most_numbers = 6;
  /// One side of the exchange: which atoms, or points, go to or come from which rank.
  struct Side {
    std::vector<int> items, counts, starts;  // [item], [rank], [rank + 1]
    std::vector<double> numbers;             // [most_numbers items]
  };
  template <int width, class Read, class Write, class Fetch>
  void carry(Side& from, Side& to, const Read& read, const Write& write, const Fetch& fetch) {
    static_assert(width <= most_numbers);
    constexpr std::size_t ahead = 32;
    const std::size_t n = from.items.size();
    if (num_ranks_ == 1) {  // items of both sides stand in the same order
      for (std::size_t k = 0; k < n; ++k) {
        if (k + ahead < n) fetch(from, to, k + ahead);
        double numbers[width];
        read(from.items[k], numbers);
        write(to.items[k], static_cast<const double*>(numbers));
      }
      return;
    }
    for (std::size_t k = 0; k < n; ++k) read(from.items[k], &from.numbers[width * k]);
    exchange(width, from, &to);
    for (std::size_t k = 0; k < to.items.size(); ++k)
      write(to.items[k], static_cast<const double*>(&to.numbers[width * k]));
  }
  void exchange(int width, const Side& from, Side* to);
  std::string find_lost() const;

  MPI_Comm world_;
  int rank_ = 0, num_ranks_ = 1;
  std::size_t num_islands_ = 0;
  std::vector<int> owners_, points_;        // [tag]
  std::vector<int> tags_;                   // [point]
  Side senders_, receivers_;                // atoms that this rank has, points that it owns
  std::vector<int> counts_[2], starts_[2];  // scratch of `exchange`
};

}  // namespace tanor::embed
