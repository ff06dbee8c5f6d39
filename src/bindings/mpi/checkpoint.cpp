#include <fcntl.h>
#include <unistd.h>

#include <array>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <stdexcept>
#include <system_error>
#include <type_traits>

#include "base/archive.hpp"
#include "base/checksum.hpp"
#include "mpi/tanor_mpi.hpp"
#include "system/fingerprint.hpp"

namespace tanor {
using namespace detail;

namespace {

namespace fs = std::filesystem;

/// The beginning of a checkpoint. The head follows, then positions and velocities of all points.
struct Header {
  std::array<char, 8> magic{'t', 'a', 'n', 'o', 'r', 'm', 'p', 'i'};
  std::uint64_t version = 3, size_of_head = 0, sum_of_head = 0;
};

struct Head {
  std::uint64_t num_points = 0, fingerprint = 0, sum_of_points = 0;
  std::string mark{};
  std::vector<std::byte> progress{};
};
template <class H, class Visit>
void visit_parts(H& head, Visit& visit) requires std::is_same_v<std::remove_const_t<H>, Head> {
  visit(head.num_points, head.fingerprint, head.sum_of_points, head.mark, head.progress);
}

std::uint64_t sum_of(std::span<const std::byte> bytes) {
  Checksum sum;
  sum.add(bytes);
  return sum.value();
}

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

/// Returns a head with the system alone. One that no rank knows belongs to the parts as they are divided.
Head head_of(const MpiRanks& ranks, const RankSystem& part, const System* whole) {
  if (whole != nullptr) return {whole->num_points(), fingerprint_of(*whole)};
  Checksum sum;
  sum.add(std::span(part.points));
  const std::array<std::uint64_t, 1> fingerprint{fingerprint_of(part.system)};
  sum.add(std::span<const std::uint64_t>(fingerprint));
  std::array<std::uint64_t, 2> all{count_to_write(ranks, part), sum.value()};
  MPI_Allreduce(MPI_IN_PLACE, all.data(), 2, MPI_UINT64_T, MPI_SUM, ranks.communicator());
  return {all[0], all[1]};
}

/// Returns the bytes in front of the points, a multiple of 8.
std::vector<std::byte> pack(const Head& head) {
  std::vector<std::byte> bytes(sizeof(Header));
  ByteWriter([&](std::span<const std::byte> part) { bytes.insert(bytes.end(), part.begin(), part.end()); })(head);
  bytes.resize((bytes.size() + 7) / 8 * 8);
  const auto behind = std::span<const std::byte>(bytes).subspan(sizeof(Header));
  const Header header{.size_of_head = behind.size(), .sum_of_head = sum_of(behind)};
  std::memcpy(bytes.data(), &header, sizeof header);
  return bytes;
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

/// Reads the head, and returns in `start` where the points begin. Every rank reads the same bytes, and finds the same
/// errors.
Head read_head(const fs::path& name, std::size_t* start = nullptr) {
  constexpr const char* damaged = "is damaged: its checksum is another one";
  std::ifstream file(name, std::ios::binary);
  if (!file) throw std::runtime_error("cannot read " + name.string());
  Header header;
  const Header expected;
  if (!file.read(reinterpret_cast<char*>(&header), sizeof header))
    refuse(name, "is no checkpoint of tanor-mpi: it ends too early");
  if (header.magic != expected.magic) refuse(name, "is no checkpoint of tanor-mpi");
  if (header.version != expected.version) refuse(name, "is of another version of tanor-mpi");
  const std::uint64_t size = fs::file_size(name);
  if (header.size_of_head > size) refuse(name, damaged);  // no number of a damaged header may reach beyond the file
  std::vector<std::byte> bytes(header.size_of_head);
  file.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  if (!file || sum_of(bytes) != header.sum_of_head) refuse(name, damaged);
  Head head;
  ByteReader(std::span<const std::byte>(bytes), [](const auto&) {})(head);
  const std::size_t end_of_head = sizeof header + bytes.size();
  if (size != end_of_head + 48 * head.num_points) refuse(name, "is damaged: it ends too early, or too late");
  if (start != nullptr) *start = end_of_head;
  return head;
}

}  // namespace

std::size_t count_to_write(const MpiRanks& ranks, const RankSystem& part) {
  return ranks.rank() == 0 ? part.points.size() - part.part.guests.size() : part.num_owned;
}

void write_checkpoint(const MpiRanks& ranks, const fs::path& name, const RankSystem& part, const System* whole,
                      const Simulation& simulation, const std::string& mark) {
  Head head = head_of(ranks, part, whole);
  const std::size_t count = count_to_write(ranks, part);
  const std::span<const Index> points(part.points.data(), count);
  const auto positions = simulation.positions().first(3 * count), velocities = simulation.velocities().first(3 * count);
  head.sum_of_points = sum_points(ranks, points, positions, velocities);
  head.mark = mark;
  head.progress = simulation.save_progress();
  const std::vector<std::byte> bytes = pack(head);
  std::uint64_t start = bytes.size();  // the file has the head of the first rank; that of others may be longer
  MPI_Bcast(&start, 1, MPI_UINT64_T, 0, ranks.communicator());
  const fs::path unfinished = name.string() + ".part";
  {
    SharedFile file(ranks, unfinished, SharedFile::Mode::Write);
    file.resize(start + 48 * head.num_points);  // an earlier file may have been longer
    file.write(0, bytes);
    file.write_points(start, 3, points, positions);
    file.write_points(start + 24 * head.num_points, 3, points, velocities);
    file.synchronize();
  }
  int error = ranks.rank() == 0 ? rename_and_wait(unfinished, name) : 0;
  MPI_Bcast(&error, 1, MPI_INT, 0, ranks.communicator());
  if (error != 0)
    throw std::runtime_error("cannot write " + name.string() + ": " + std::generic_category().message(error));
}

void read_checkpoint(const MpiRanks& ranks, const fs::path& name, const RankSystem& part, const System* whole,
                     Simulation* simulation) {
  const Head expected = head_of(ranks, part, whole);
  SharedFile file(ranks, name, SharedFile::Mode::Read);
  std::size_t start = 0;
  const Head head = read_head(name, &start);
  if (head.num_points != expected.num_points)
    refuse(name, "belongs to another system: it holds " + std::to_string(head.num_points) + " points, the system has " +
                     std::to_string(expected.num_points));
  if (head.fingerprint != expected.fingerprint) refuse(name, "belongs to another system");
  std::vector<double> positions(3 * part.points.size()), velocities(positions.size());
  file.read_points(start, 3, part.points, positions);
  file.read_points(start + 24 * head.num_points, 3, part.points, velocities);
  const std::span<const Index> points(part.points.data(), count_to_write(ranks, part));
  if (sum_points(ranks, points, positions, velocities) != head.sum_of_points)
    refuse(name, "is damaged: the checksum of its points is another one");
  simulation->restore_progress(head.progress, positions, velocities);
}

std::string read_checkpoint_mark(const fs::path& name) {
  return read_head(name).mark;
}

}  // namespace tanor
