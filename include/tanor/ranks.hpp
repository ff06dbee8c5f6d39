#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include <tanor/export.hpp>
#include <tanor/system.hpp>

/// \file
/// A system that is spread over several processes, its ranks, which tanor knows through `Ranks` alone (MPI: tanor-mpi).
namespace tanor {

/// Equations that join points of several ranks. Each rank eliminates all its other equations; the remaining matrices on
/// the shared ones are summed and solved here. All functions are collective.
class TANOR_API SharedRows {
 public:
  virtual ~SharedRows();
  /// Sums the symmetric matrices of the ranks, each on its own shared rows (the lower triangle, column after column),
  /// and factorizes the sum. Returns its 1/cond, with rows scaled to a unit diagonal, as the pivots show it, or the
  /// least number on the diagonal of the sum if that is smaller; 0 if the sum is not positive definite. The numbers on
  /// the diagonal are 1 at most: what the elimination of other rows has left. The result is the same on every rank.
  virtual double factorize(std::span<const double> triangle) = 0;
  /// Sums the right sides of the ranks, [own shared rows], and solves; `x` becomes the unknowns of these rows.
  virtual void solve(std::span<double> x) = 0;
};

/// Processes that compute one system together. All functions but `rank` and `size` are collective: every rank calls
/// them, in the same order. What they return has the same bits on every rank.
class TANOR_API Ranks {
 public:
  virtual ~Ranks();

  virtual int rank() const = 0;
  virtual int size() const = 0;

  /// Replaces each number by its sum over all ranks.
  virtual void sum(std::span<double> numbers) = 0;
  /// Replaces each number by its largest value over all ranks. No number is NaN.
  virtual void find_largest(std::span<double> numbers) = 0;
  /// Gives every rank the text of rank `from`.
  virtual void share(int from, std::string* text) = 0;

  /// Numbers sent to another rank, and numbers received from it.
  struct Message {
    int rank;
    std::span<const double> sent;
    std::span<double> received;
  };
  virtual void exchange(std::span<const Message> messages) = 0;

  /// Makes the solver of `num_rows` shared rows, of which this rank has those in `own`. If it returns null, each rank
  /// solves all of them.
  virtual std::unique_ptr<SharedRows> make_shared_rows(std::size_t num_rows, std::span<const std::size_t> own);
};

/// The knowledge of a rank about its part of a system, beside the part itself.
///
/// Every moving point has one rank, its owner. The System of a rank has the points that it owns, the supports that
/// these need, and guests: points of other ranks that equations or forces join to its own. Guests are listed as
/// supports; their motion comes from their owners.
struct Part {
  Ranks* ranks = nullptr;       ///< outlives the simulation; null if all of the system is here
  std::vector<Index> guests{};  ///< numbers in the rank's System

  /// States exchanged with one rank: own points that are guests there are sent, and guests from there are received.
  struct Link {
    int rank;
    std::vector<Index> sent, received;
  };
  std::vector<Link> links{};

  /// An equation of this System that joins own points and guests. Every rank that owns one of its points has it.
  struct SharedRow {
    std::size_t equation;  ///< in the rank's System
    std::size_t place;     ///< its number among the shared equations of all ranks
    bool is_counted;       ///< true on one of the ranks that have it
  };
  std::vector<SharedRow> shared_rows{};
  std::size_t num_shared_rows = 0;  ///< number over all ranks
  /// False if the constraints of the whole system are distances without loops, so that K has full rank everywhere.
  bool may_lose_rank = true;

  /// Forces of this System that join own points and guests and whose energies another rank counts. Every rank that owns
  /// one of their points has them, for their effect on its own points. Of pair forces without a cutoff, each of two
  /// ranks counts half of the energy of a pair.
  std::vector<std::size_t> energies_counted_elsewhere{};
  /// Number over all ranks of springs, bonds, formulas … and pairs without a cutoff between points of several ranks.
  std::size_t num_shared_tuples = 0;

  /// A group of pair forces with a cutoff between points of several ranks. Those between own points are in this System
  /// as well.
  struct SharedPairs {
    PairForces law;              ///< law with this rank's own points; there may be none
    std::vector<Index> numbers;  ///< numbers of these points in the whole system
    /// Pairs without a force between them: one of these points by its place in the list, another rank's point by its
    /// number.
    std::vector<std::array<Index, 2>> excluded;
  };
  std::vector<SharedPairs> shared_pairs{};  ///< the same number on every rank, in the same order

  /// [point] Number of the point's island or neighbourhood among those that lie on several ranks, or -1. Empty if there
  /// are none.
  std::vector<Index> shared_neighbourhood{};
  std::size_t num_shared_neighbourhoods = 0;

  bool is_whole() const { return ranks == nullptr || ranks->size() == 1; }
  /// Returns true if equations or forces reach from rank to rank, here or elsewhere.
  bool is_cut() const { return num_shared_rows + num_shared_tuples + shared_pairs.size() > 0; }
};

/// One rank's part of a system.
struct RankSystem {
  System system;
  Part part;
  std::vector<Index> points;           ///< [point of `system`] number in the whole system
  std::vector<std::size_t> equations;  ///< [equation of `system`] likewise
  /// Number of own points, which come first in `system`. Guests and all supports follow in a part that was taken out,
  /// nothing in one that a rank has brought.
  std::size_t num_owned = 0;
};

/// Takes out the points of one rank, with all that acts on them. `owner` [point] is the rank of each moving point (that
/// of a support does not matter), the same on every rank. Not collective. Throws InputError if something that one rank
/// must have whole joins points of several ranks.
TANOR_API RankSystem take_part(const System& system, std::span<const int> owner, Ranks& ranks);

/// Joins parts that the ranks bring, so that none of them ever holds the whole system: whole islands, with all forces
/// and supports that act on them. Nothing reaches from rank to rank. All points of a rank are its own, in the order
/// given; points and equations of the whole system are numbered rank after rank. Collective. Throws InputError on all
/// ranks if some have coordinates and others none, or if there are more points than an Index counts.
TANOR_API RankSystem join_parts(System own, Ranks& ranks);

}  // namespace tanor
