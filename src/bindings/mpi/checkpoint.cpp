#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <stdexcept>
#include <system_error>

#include "base/checksum.hpp"
#include "mpi/tanor_mpi.hpp"
#include "system/fingerprint.hpp"

namespace tanor {
using namespace detail;

namespace {

namespace fs = std::filesystem;

/// The beginning of a checkpoint. The mark and the motion's progress follow, with zeros up to a multiple of 8 bytes.
/// These are the head; then come positions and velocities of all points.
struct Header {
  std::array<char, 8> magic{'t', 'a', 'n', 'o', 'r', 'm', 'p', 'i'};
  std::uint64_t version = 2, num_points = 0, fingerprint = 0, mark_size = 0, progress_size = 0;
  std::uint64_t sum_of_points = 0, sum_of_head = 0;  ///< the second is of the head without itself

  std::size_t head_size() const { return (sizeof(Header) + mark_size + progress_size + 7) / 8 * 8; }
  std::size_t positions() const { return head_size(); }
  std::size_t velocities() const { return head_size() + 24 * num_points; }
  std::size_t file_size() const { return head_size() + 48 * num_points; }
};

/// The header and all that follows up to the points.
struct Head {
  Header header;
  std::vector<std::byte> bytes;

  std::span<const std::byte> mark() const { return std::span(bytes).subspan(sizeof header, header.mark_size); }
  std::span<const std::byte> progress() const {
    return std::span(bytes).subspan(sizeof header + header.mark_size, header.progress_size);
  }
  /// Sets the sum and writes the header to its bytes.
  void seal() {
    header.sum_of_head = 0;
    std::memcpy(bytes.data(), &header, sizeof header);
    header.sum_of_head = sum();
    std::memcpy(bytes.data(), &header, sizeof header);
  }
  bool is_sound() const {
    Head copy = *this;
    copy.seal();
    return copy.header.sum_of_head == header.sum_of_head;
  }

 private:
  std::uint64_t sum() const {
    Checksum sum;
    sum.add(bytes);
    return sum.value();
  }
};

/// Returns the sum over the points of a checksum of each point's number and state, which is the same for any number of
/// ranks.
std::uint64_t sum_points(const MpiRanks& ranks, std::span<const Index> points, std::span<const double> positions,
                         std::span<const double> velocities) {
  std::uint64_t own = 0, all = 0;
  for (std::size_t k = 0; k < points.size(); ++k) {
    Checksum sum;
    sum.add(points.subspan(k, 1));
    sum.add(positions.subspan(3 * k, 3));
    sum.add(velocities.subspan(3 * k, 3));
    own += sum.value();
  }
  MPI_Allreduce(&own, &all, 1, MPI_UINT64_T, MPI_SUM, ranks.communicator());
  return all;
}

/// The system of a checkpoint.
struct Identity {
  std::uint64_t num_points, fingerprint;
};

Identity identity_of(const System& whole) {
  return {whole.num_points(), fingerprint_of(whole)};
}

/// Returns the identity of a system that no rank knows. It belongs to the parts as they are divided.
Identity identity_of(const MpiRanks& ranks, const RankSystem& part) {
  Checksum sum;
  sum.add(std::span(part.points));
  const std::array<std::uint64_t, 1> fingerprint{fingerprint_of(part.system)};
  sum.add(std::span<const std::uint64_t>(fingerprint));
  const std::array<std::uint64_t, 2> own{count_to_write(ranks, part), sum.value()};
  std::array<std::uint64_t, 2> all{};
  MPI_Allreduce(own.data(), all.data(), 2, MPI_UINT64_T, MPI_SUM, ranks.communicator());
  return {all[0], all[1]};
}

/// Makes the head. The file has the head of the first rank; the progress of others may have other lengths.
Head make_head(const MpiRanks& ranks, const Header& header, const std::string& mark,
               std::span<const std::byte> progress) {
  Head head{header, {}};
  head.header.mark_size = mark.size();
  head.header.progress_size = progress.size();
  MPI_Bcast(&head.header, sizeof head.header, MPI_BYTE, 0, ranks.communicator());
  if (ranks.rank() != 0) return head;
  head.bytes.resize(head.header.head_size());
  const auto after_mark = std::ranges::copy(std::as_bytes(std::span(mark)), head.bytes.begin() + sizeof(Header)).out;
  std::ranges::copy(progress, after_mark);
  head.seal();
  return head;
}

/// Renames a file and returns the error, or 0. A disk has the new name when it has the folder.
int rename_and_wait(const fs::path& from, const fs::path& to) {
  std::error_code error;
  fs::rename(from, to, error);
  if (error) return error.value();
  const int folder = open(to.has_parent_path() ? to.parent_path().c_str() : ".", O_RDONLY | O_DIRECTORY);
  if (folder < 0) return 0;  // this file system opens no folders
  fsync(folder);
  close(folder);
  return 0;
}

[[noreturn]] void refuse(const fs::path& name, const std::string& why) {
  throw InputError(name.string(), why);
}

/// Reads the head. Every rank reads the same bytes, and finds the same errors.
Head read_head(SharedFile* file, const fs::path& name) {
  constexpr const char* damaged = "is damaged: its checksum is another one";
  Head head;
  const Header expected;
  head.bytes = file->read(0, sizeof head.header);
  if (head.bytes.size() < sizeof head.header) refuse(name, "is no checkpoint of tanor-mpi: it ends too early");
  std::memcpy(&head.header, head.bytes.data(), sizeof head.header);
  if (head.header.magic != expected.magic) refuse(name, "is no checkpoint of tanor-mpi");
  if (head.header.version != expected.version) refuse(name, "is of another version of tanor-mpi");
  const Header& header = head.header;
  const std::uint64_t size = fs::file_size(name);
  // No number of a damaged header may reach beyond the file.
  if (header.mark_size > size || header.progress_size > size || header.num_points > size / 48) refuse(name, damaged);
  if (size != header.file_size()) refuse(name, "is damaged: it ends too early, or too late");
  head.bytes = file->read(0, header.head_size());
  if (!head.is_sound()) refuse(name, damaged);
  return head;
}

void write(const MpiRanks& ranks, const fs::path& name, const RankSystem& part, const Identity& identity,
           const Simulation& simulation, const std::string& mark) {
  const std::size_t count = count_to_write(ranks, part);
  const std::span<const Index> points(part.points.data(), count);
  const auto positions = simulation.positions().first(3 * count), velocities = simulation.velocities().first(3 * count);
  Header header;
  header.num_points = identity.num_points;
  header.fingerprint = identity.fingerprint;
  header.sum_of_points = sum_points(ranks, points, positions, velocities);
  const Head head = make_head(ranks, header, mark, simulation.save_progress());
  const fs::path unfinished = name.string() + ".part";
  {
    SharedFile file(ranks, unfinished, SharedFile::Mode::Write);
    file.resize(head.header.file_size());  // an earlier file may have been longer
    file.write(0, head.bytes);
    file.write_points(head.header.positions(), 3, points, positions);
    file.write_points(head.header.velocities(), 3, points, velocities);
    file.synchronize();
  }
  int error = ranks.rank() == 0 ? rename_and_wait(unfinished, name) : 0;
  MPI_Bcast(&error, 1, MPI_INT, 0, ranks.communicator());
  if (error != 0)
    throw std::runtime_error("cannot write " + name.string() + ": " + std::generic_category().message(error));
}

void read(const MpiRanks& ranks, const fs::path& name, const RankSystem& part, const Identity& identity,
          Simulation* simulation) {
  SharedFile file(ranks, name, SharedFile::Mode::Read);
  const Head head = read_head(&file, name);
  const Header& header = head.header;
  if (header.num_points != identity.num_points)
    refuse(name, "belongs to another system: it holds " + std::to_string(header.num_points) +
                     " points, the system has " + std::to_string(identity.num_points));
  if (header.fingerprint != identity.fingerprint) refuse(name, "belongs to another system");
  std::vector<double> positions(3 * part.points.size()), velocities(positions.size());
  file.read_points(header.positions(), 3, part.points, positions);
  file.read_points(header.velocities(), 3, part.points, velocities);
  const std::span<const Index> points(part.points.data(), count_to_write(ranks, part));
  if (sum_points(ranks, points, positions, velocities) != header.sum_of_points)
    refuse(name, "is damaged: the checksum of its points is another one");
  simulation->restore_progress(head.progress(), positions, velocities);
}

}  // namespace

std::size_t count_to_write(const MpiRanks& ranks, const RankSystem& part) {
  return ranks.rank() == 0 ? part.points.size() - part.part.guests.size() : part.num_owned;
}

void write_checkpoint(const MpiRanks& ranks, const fs::path& name, const RankSystem& part, const System& whole,
                      const Simulation& simulation, const std::string& mark) {
  write(ranks, name, part, identity_of(whole), simulation, mark);
}

void write_checkpoint(const MpiRanks& ranks, const fs::path& name, const RankSystem& part, const Simulation& simulation,
                      const std::string& mark) {
  write(ranks, name, part, identity_of(ranks, part), simulation, mark);
}

void read_checkpoint(const MpiRanks& ranks, const fs::path& name, const RankSystem& part, const System& whole,
                     Simulation* simulation) {
  read(ranks, name, part, identity_of(whole), simulation);
}

void read_checkpoint(const MpiRanks& ranks, const fs::path& name, const RankSystem& part, Simulation* simulation) {
  read(ranks, name, part, identity_of(ranks, part), simulation);
}

std::string read_checkpoint_mark(const MpiRanks& ranks, const fs::path& name) {
  SharedFile file(ranks, name, SharedFile::Mode::Read);
  const Head head = read_head(&file, name);
  return {reinterpret_cast<const char*>(head.mark().data()), head.mark().size()};
}

}  // namespace tanor
