#pragma once

#include <mpi.h>

#include <cstddef>
#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include <tanor/motion.hpp>
#include <tanor/ranks.hpp>

/// \file tanor on many machines: ranks of MPI, the assignment of points to ranks, and files that all ranks write
/// together. This is the library `tanor_mpi`; libtanor knows no MPI.
namespace tanor {

/// The processes of a communicator, which belongs to the host and outlives this object.
class TANOR_API MpiRanks final : public Ranks {
 public:
  /// Takes the communicator. If there are more than `most_replicated` shared rows, they are spread over the ranks and
  /// factorized by ScaLAPACK, provided that tanor_mpi was built with it; otherwise each rank solves all of them.
  explicit MpiRanks(MPI_Comm communicator, std::size_t most_replicated = 3000);

  MPI_Comm communicator() const { return communicator_; }
  int rank() const override { return rank_; }
  int size() const override { return size_; }

  void sum(std::span<double> numbers) override { reduce(numbers, MPI_SUM); }
  void find_largest(std::span<double> numbers) override { reduce(numbers, MPI_MAX); }
  void share(int from, std::string* text) override;
  void exchange(std::span<const Message> messages) override;
  std::unique_ptr<SharedRows> make_shared_rows(std::size_t num_rows, std::span<const std::size_t> own) override;

 private:
  void reduce(std::span<double> numbers, MPI_Op operation);

  MPI_Comm communicator_;
  int rank_ = 0, size_ = 1;
  std::size_t most_replicated_;
  std::vector<MPI_Request> requests_;
};

/// Tells if points that constraints or forces join may lie on several ranks.
enum class Islands { MayBeCut, AreWhole };

/// Returns [point] the rank that owns each point that moves, and 0 for supports. The result is the same on every rank.
///
/// Points that constraints and forces join stay together, and go where they balance the predicted cost of the ranks. A
/// group that costs more than a rank's share is cut into pieces with METIS, its points being the graph's vertices,
/// unless `islands` are whole, as implicit methods want them (`wants_whole_islands`). Friction and coordinates also
/// keep them whole. Throws InputError if a rank would own nothing.
TANOR_API std::vector<int> assign_owners(const System& system, int num_ranks, Islands islands = Islands::MayBeCut);

/// An array of the numbers of points, of which every rank has some, in a file that all ranks write together. Numbers
/// stand in the order of all points. All functions are collective and throw std::runtime_error if a file fails.
class TANOR_API SharedFile {
 public:
  enum class Mode { Read, Write };
  SharedFile(const MpiRanks& ranks, const std::filesystem::path& name, Mode mode);
  ~SharedFile();
  SharedFile(const SharedFile&) = delete;
  SharedFile& operator=(const SharedFile&) = delete;

  /// Cuts off what lies behind so many bytes, or adds zeros.
  void resize(std::size_t size);
  /// Waits until the disk has what was written.
  void synchronize();
  /// Writes bytes of the first rank at an offset.
  void write(std::size_t offset, std::span<const std::byte> bytes);
  /// Writes `width` numbers for each of these points, which stand in `numbers` point by point. Point p of all stands at
  /// offset + 8 width p bytes.
  void write_points(std::size_t offset, std::size_t width, std::span<const Index> points,
                    std::span<const double> numbers);
  void read_points(std::size_t offset, std::size_t width, std::span<const Index> points, std::span<double> numbers);

 private:
  /// Reads or writes points, in this order, in units of this type, and returns the error of MPI.
  using Transfer = std::function<int(std::span<const std::size_t> order, MPI_Datatype point)>;
  void transfer_points(std::size_t offset, std::size_t width, std::span<const Index> points, const Transfer& transfer);

  const MpiRanks& ranks_;
  std::string name_;
  MPI_File file_ = MPI_FILE_NULL;
};

/// Returns how many of its points, the first ones, a rank writes into such a file. It writes those that it owns, and
/// the first rank the supports too, so that the file has all of them.
TANOR_API std::size_t count_to_write(const MpiRanks& ranks, const RankSystem& part);

/// Saves a motion so that it can be resumed: on any number of ranks if it is of a part of `whole`, else, as after
/// `join_parts`, on the same parts. The file is replaced when the disk has all of it. `mark` is what the host knows its
/// input by, the same on every rank.
TANOR_API void write_checkpoint(const MpiRanks& ranks, const std::filesystem::path& name, const RankSystem& part,
                                const System* whole, const Simulation& simulation, const std::string& mark = {});
/// Goes on from a checkpoint. Throws InputError if one byte of the file is not what was written, or if it is of a
/// system with other points, masses, supports, members of constraints or kinds of entries. (What functions compute
/// cannot be compared, so a host marks its files.)
TANOR_API void read_checkpoint(const MpiRanks& ranks, const std::filesystem::path& name, const RankSystem& part,
                               const System* whole, Simulation* simulation);
/// Returns the mark of a file. Throws InputError if the file is no checkpoint, or its mark is damaged. Any rank reads
/// it without the others.
TANOR_API std::string read_checkpoint_mark(const std::filesystem::path& name);

}  // namespace tanor
