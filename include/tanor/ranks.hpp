#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include <tanor/export.hpp>
#include <tanor/system.hpp>

/// \file A system that is spread over several processes, its ranks. tanor knows these by `Ranks` alone: tanor-mpi has
/// them for MPI, a host may bring its own.
namespace tanor {

/// Equations that join points of several ranks. Each rank eliminates all its other equations; what is left over on the
/// shared ones is summed and solved here. All functions are collective.
class TANOR_API SharedRows {
 public:
  virtual ~SharedRows();
  /// Sums the symmetric matrices of the ranks, each on its own shared rows (the lower triangle, column after column),
  /// and factorizes the sum. Returns 1/cond of it with its rows scaled to a unit diagonal, as its pivots tell; 0: it is
  /// not positive definite. The same on every rank.
  virtual double factorize(std::span<const double> triangle) = 0;
  /// Sums the right sides of the ranks, [own shared rows], and solves: what is left are the unknowns of these rows.
  virtual void solve(std::span<double> x) = 0;
};

/// Processes that compute one system together. All functions but `rank` and `size` are collective: every rank calls
/// them, in the same order. What they return has the same bits on every rank.
class TANOR_API Ranks {
 public:
  virtual ~Ranks();

  virtual int rank() const = 0;
  virtual int size() const = 0;

  /// Number by number, the sums over all ranks.
  virtual void sum(std::span<double> numbers) = 0;
  /// Likewise the largest ones. Nobody has a NaN.
  virtual void find_largest(std::span<double> numbers) = 0;
  /// The text that rank `from` has.
  virtual void share(int from, std::string* text) = 0;

  /// Numbers that go to another rank, and those that come from there.
  struct Message {
    int rank;
    std::span<const double> sent;
    std::span<double> received;
  };
  virtual void exchange(std::span<const Message> messages) = 0;

  /// Who solves `num_rows` shared rows, of which this rank has those in `own`. Null: each rank solves all of them.
  virtual std::unique_ptr<SharedRows> make_shared_rows(std::size_t num_rows, std::span<const std::size_t> own);
};

/// What a rank knows about its part of a system, beside the part itself.
///
/// Every point that moves has one rank, its owner. The System of a rank has the points that it owns, the supports that
/// these need, and guests: points of others that equations or forces join to its own ones. Guests are listed as
/// supports; their motion comes from their owners.
struct Part {
  Ranks* ranks = nullptr;       ///< outlives the simulation; null: all of the system is here
  std::vector<Index> guests{};  ///< of the rank's System

  /// Own points that are guests elsewhere, and guests: their states go to that rank, and come from there.
  struct Link {
    int rank;
    std::vector<Index> sent, received;
  };
  std::vector<Link> links{};

  /// An equation of this System that joins own points and guests. Every rank that owns one of its points has it.
  struct SharedRow {
    std::size_t equation;  ///< in the rank's System
    std::size_t place;     ///< among those of all ranks
    bool is_counted;       ///< by this rank: by one of those that have it
  };
  std::vector<SharedRow> shared_rows{};
  std::size_t num_shared_rows = 0;  ///< of all ranks
  /// Constraints of the whole system close loops or are no distances: else K has full rank everywhere.
  bool may_lose_rank = true;

  /// Forces of this System that join own points and guests and whose energies another rank counts. Every rank that owns
  /// one of their points has them, for what they do to its own.
  std::vector<std::size_t> energies_counted_elsewhere{};
  std::size_t num_shared_tuples = 0;  ///< of all ranks: springs, bonds, formulas … between their points

  /// A group of pair forces with a cutoff between points of several ranks; those between own points are in this System
  /// as well.
  struct SharedPairs {
    PairForces law;              ///< its points are this rank's own ones; there may be none
    std::vector<Index> numbers;  ///< of these points, in the whole system
    /// Pairs that leave each other alone: of these points one by its place in the list, another rank's by its number.
    std::vector<std::array<Index, 2>> excluded;
  };
  std::vector<SharedPairs> shared_pairs{};  ///< as many on every rank, in the same order

  /// [point] The number of the island or neighbourhood, of those that lie on several ranks, which a point belongs to;
  /// -1: of none. Empty: there are none.
  std::vector<Index> shared_neighbourhood{};
  std::size_t num_shared_neighbourhoods = 0;

  bool is_whole() const { return ranks == nullptr || ranks->size() == 1; }
  /// Equations or forces reach from rank to rank, here or elsewhere.
  bool is_cut() const { return num_shared_rows + num_shared_tuples + shared_pairs.size() > 0; }
};

/// A rank's part of a system that all ranks know.
struct RankSystem {
  System system;
  Part part;
  std::vector<Index> points;           ///< [point of `system`] in the whole system
  std::vector<std::size_t> equations;  ///< [equation of `system`] likewise
  std::size_t num_owned = 0;           ///< the first points of `system`; supports and guests follow
};

/// Takes out the points of one rank, with all that acts on them. `owner` [point]: the rank of each point that moves
/// (that of a support does not matter), the same on every rank. Not collective. Throws InputError where something joins
/// points of several ranks that one rank must have, or cannot be taken apart.
TANOR_API RankSystem take_part(const System& system, std::span<const int> owner, Ranks& ranks);

}  // namespace tanor
