/// Systems that METIS cuts for the ranks of this run are compared with the same systems on one rank: mpirun -n P
/// test_mpi.
/// The program ends with 1 where an answer is wrong.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <functional>
#include <limits>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

#include "mpi/metis_counts.hpp"
#include "mpi/pieces.hpp"
#include "scenes.hpp"
#include "tanor_mpi.hpp"

namespace {

using namespace tanor;

bool is_first(const MpiRanks& ranks) {
  return ranks.rank() == 0;
}

/// Returns on every rank the largest difference of own points from those of the whole, over the largest number there.
double difference(MpiRanks& ranks, const RankSystem& part, std::span<const double> own, std::span<const double> whole) {
  double largest[2] = {0.0, 0.0};
  for (const double each : whole) largest[1] = std::max(largest[1], std::abs(each));
  for (std::size_t i = 0; i < part.num_owned; ++i)
    for (std::size_t c = 0; c < 3; ++c)
      largest[0] =
          std::max(largest[0], std::abs(own[3 * i + c] - whole[3 * static_cast<std::size_t>(part.points[i]) + c]));
  ranks.find_largest(largest);
  return largest[0] / (largest[1] > 0.0 ? largest[1] : 1.0);
}

struct Checks {
  MpiRanks& ranks;
  int failures = 0;

  void expect(bool holds, const std::string& what) {
    double wrong[1] = {holds ? 0.0 : 1.0};
    ranks.find_largest(wrong);
    if (wrong[0] == 0.0) return;
    ++failures;
    if (is_first(ranks)) std::printf("wrong: %s\n", what.c_str());
  }
};

MotionOptions options_of(Method method, double step) {
  MotionOptions options;
  options.method = method;
  options.step = step;
  options.start = StartMode::Project;
  return options;
}

/// Compares the accelerations at the start, and the state after a few steps.
void compare(Checks* checks, const std::string& name, const System& system, MotionOptions options, double t_end) {
  MpiRanks& ranks = checks->ranks;
  Simulation whole(system, options, {.threads = 1});
  const RankSystem part = take_part(system, assign_owners(system, ranks.size()), ranks);
  Simulation own(part.system, part.part, options, {.threads = 1});
  checks->expect(own.outcome().ok() && whole.outcome().ok(), name + ": " + own.outcome().what);
  const double error = difference(ranks, part, own.accelerations(), whole.accelerations());
  checks->expect(error <= 1e-12, name + ": accelerations differ by " + std::to_string(1e12 * error) + "e-12");
  if (t_end == 0.0) return;
  const bool is_fine = own.advance_to(t_end).ok() && whole.advance_to(t_end).ok();
  checks->expect(is_fine, name + ": " + own.outcome().what);
  checks->expect(own.report().steps == whole.report().steps, name + ": " + std::to_string(own.report().steps) +
                                                                 " steps, not " + std::to_string(whole.report().steps));
  const double moved = difference(ranks, part, own.positions(), whole.positions());
  checks->expect(moved <= 1e-9, name + ": positions differ by " + std::to_string(1e9 * moved) + "e-9");
}

/// Ranks that spread their shared rows over all ranks, however few rows there are, and count their messages.
class SpreadRanks final : public Ranks {
 public:
  explicit SpreadRanks(MPI_Comm communicator) : ranks_(communicator, 0) {}
  int rank() const override { return ranks_.rank(); }
  int size() const override { return ranks_.size(); }
  void sum(std::span<double> numbers) override { ranks_.sum(numbers); }
  void find_largest(std::span<double> numbers) override { ranks_.find_largest(numbers); }
  void share(int from, std::string* text) override { ranks_.share(from, text); }
  void exchange(std::span<const Message> messages) override {
    num_messages += messages.size();
    ranks_.exchange(messages);
  }
  std::unique_ptr<SharedRows> make_shared_rows(std::size_t num_rows, std::span<const std::size_t> own) override {
    return ranks_.make_shared_rows(num_rows, own);
  }
  std::size_t num_messages = 0;

 private:
  MpiRanks ranks_;
};

void compare_spread(Checks* checks, const System& system) {
  SpreadRanks spread(MPI_COMM_WORLD);
  const MotionOptions options = options_of(Method::Dop853, 0.0);
  Simulation whole(system, options, {.threads = 1});
  const RankSystem part = take_part(system, assign_owners(system, spread.size()), spread);
  Simulation own(part.system, part.part, options, {.threads = 1});
  checks->expect(own.outcome().ok(), "spread rows: " + own.outcome().what);
  const double error = difference(checks->ranks, part, own.accelerations(), whole.accelerations());
  checks->expect(error <= 1e-12, "spread rows: accelerations differ by " + std::to_string(1e12 * error) + "e-12");
}

/// Ranks with whole islands exchange nothing but reductions.
void compare_clusters(Checks* checks) {
  compare(checks, "clusters, taylor", scenes::make_clusters(40), options_of(Method::Taylor, 0.0), 0.05);
  compare(checks, "clusters, rattle", scenes::make_clusters(40), options_of(Method::Rattle, 1e-3), 0.02);
  compare(checks, "clusters, dop853", scenes::make_clusters(40), options_of(Method::Dop853, 0.0), 0.05);
  SpreadRanks counted(MPI_COMM_WORLD);
  const auto count_messages = [&](const System& system) {
    const RankSystem part = take_part(system, assign_owners(system, counted.size()), counted);
    Simulation own(part.system, part.part, options_of(Method::Dop853, 0.0), {.threads = 1});
    checks->expect(own.advance_to(0.01).ok(), "messages are counted: " + own.outcome().what);
    return std::exchange(counted.num_messages, 0);
  };
  checks->expect(count_messages(scenes::make_clusters(40)) == 0, "clusters send messages");
  checks->expect(count_messages(scenes::make_net(9, 8)) > 0, "a net that is cut sends messages");
}

/// Changes a file on the first rank while the others wait.
void change(const MpiRanks& ranks, const std::function<void()>& work) {
  MPI_Barrier(ranks.communicator());
  if (is_first(ranks)) work();
  MPI_Barrier(ranks.communicator());
}

void turn_bit(const std::filesystem::path& name, std::size_t offset) {
  std::fstream file(name, std::ios::in | std::ios::out | std::ios::binary);
  file.seekg(static_cast<std::streamoff>(offset));
  const int byte = file.get();
  file.seekp(static_cast<std::streamoff>(offset));
  file.put(static_cast<char>(byte ^ 4));
}

/// A motion that was saved on disk, with checks of what reading it reports.
class Saved {
 public:
  Saved(Checks* checks, System system)
      : checks_(*checks),
        system_(std::move(system)),
        name_("checkpoint_of_" + std::to_string(checks->ranks.size()) + "_ranks.mpi"),
        part_(take_part(system_, assign_owners(system_, checks->ranks.size()), checks->ranks)),
        simulation_(part_.system, part_.part, options_of(Method::Rattle, 1e-3), {.threads = 1}) {
    // This is what a killed run left of a longer file.
    change(checks_.ranks, [&] { std::ofstream(name_ + ".part") << std::string(100'000, 'x'); });
    checks_.expect(simulation_.advance_to(5e-3).ok(), "the motion to save");
    write_checkpoint(checks_.ranks, name_, part_, &system_, simulation_, "a mark");
  }
  ~Saved() {
    change(checks_.ranks, [&] { std::filesystem::remove(name_); });
  }

  void check_whole() {
    checks_.expect(complaint(system_).empty(), "a whole checkpoint: " + complaint(system_));
    checks_.expect(read_checkpoint_mark(name_) == "a mark", "the mark of a checkpoint");
    Simulation fresh(part_.system, part_.part, options_of(Method::Rattle, 1e-3), {.threads = 1});
    read_checkpoint(checks_.ranks, name_, part_, &system_, &fresh);
    checks_.expect(std::ranges::equal(fresh.positions(), simulation_.positions()) &&
                       std::ranges::equal(fresh.velocities(), simulation_.velocities()) && fresh.time() == 5e-3,
                   "a checkpoint is read as it was written");
  }

  void check_other_systems() {
    System heavier = system_, crossed = system_, larger = scenes::make_net(7, 5);
    heavier.masses[3] *= 1.0 + 1e-15;
    std::get<Rods>(crossed.constraints.front()).pairs.front()[1] += 1;
    for (const System* other : {&heavier, &crossed, &larger})
      checks_.expect(complaint(*other).find("another system") != std::string::npos,
                     "another system: " + complaint(*other));
  }

  /// The damage of every 13th byte meets each number of the header and all that follows.
  void check_damage() {
    const std::size_t size = std::filesystem::file_size(name_);
    for (std::size_t offset = 0; offset < size; offset += 13) {
      change(checks_.ranks, [&] { turn_bit(name_, offset); });
      checks_.expect(!complaint(system_).empty(), "byte " + std::to_string(offset) + " is another one");
      change(checks_.ranks, [&] { turn_bit(name_, offset); });
    }
    for (const std::size_t wrong : {std::size_t{0}, std::size_t{10}, size / 2, size - 1, size + 8}) {
      change(checks_.ranks, [&] { std::filesystem::resize_file(name_, wrong); });
      checks_.expect(!complaint(system_).empty(), std::to_string(wrong) + " bytes of " + std::to_string(size));
    }
  }

 private:
  /// Returns the message of reading the file for a system, or an empty text; it is the same on every rank. The cut is
  /// that of
  /// the saved system, since reading another one fails before it matters.
  std::string complaint(const System& system) {
    try {
      read_checkpoint(checks_.ranks, name_, part_, &system, &simulation_);
    } catch (const InputError& error) {
      return error.what();
    }
    return {};
  }

  Checks& checks_;
  System system_;
  std::string name_;
  RankSystem part_;
  Simulation simulation_;
};

void check_checkpoints(Checks* checks) {
  Saved saved(checks, scenes::make_net(6, 5));
  saved.check_whole();
  saved.check_other_systems();
  saved.check_damage();
}

/// Each rank makes its own chains, as many as its number and one, and nobody the whole system. A checkpoint goes on
/// with these parts alone.
void check_joined_parts(Checks* checks) {
  MpiRanks& ranks = checks->ranks;
  const MotionOptions options = options_of(Method::Rattle, 1e-3);
  const auto join = [&](std::size_t count) { return join_parts(scenes::make_clusters(count), ranks); };
  const auto own_count = static_cast<std::size_t>(ranks.rank()) + 1;
  const RankSystem own = join(own_count), other = join(static_cast<std::size_t>(ranks.size()) - own_count + 1);
  const std::string name = "joined_on_" + std::to_string(ranks.size()) + "_ranks.mpi";
  Simulation first(own.system, own.part, options, {.threads = 1}),
      second(own.system, own.part, options, {.threads = 1}), wrong(other.system, other.part, options, {.threads = 1});
  checks->expect(first.advance_to(0.01).ok(), "joined parts move");
  write_checkpoint(ranks, name, own, nullptr, first);
  read_checkpoint(ranks, name, own, nullptr, &second);
  checks->expect(std::ranges::equal(second.positions(), first.positions()) &&
                     std::ranges::equal(second.velocities(), first.velocities()) && second.time() == 0.01,
                 "a checkpoint of joined parts is read as it was written");
  checks->expect(second.advance_to(0.02).ok(), "joined parts go on");
  std::string message;
  try {
    read_checkpoint(ranks, name, other, nullptr, &wrong);
  } catch (const InputError& error) {
    message = error.what();
  }
  checks->expect(message.find("another system") != std::string::npos, "parts of another division: " + message);
  change(ranks, [&] { std::filesystem::remove(name); });
}

/// Arrays that are longer than a piece are visited whole and in order.
void check_pieces(Checks* checks) {
  std::vector<double> numbers(1003);
  std::iota(numbers.begin(), numbers.end(), 1000.0 * checks->ranks.rank());
  std::vector<int> counts;
  std::vector<double> joined;
  in_pieces(
      std::span(numbers),
      [&](const double* first, int count) {
        counts.push_back(count);
        joined.insert(joined.end(), first, first + count);
      },
      400);
  checks->expect(counts == std::vector{400, 400, 203} && joined == numbers, "an array cut into pieces");
}

/// Makes a long chain beside free points that repel each other, whose pairs may reach from rank to rank.
System make_chain_and_beads() {
  System system = scenes::make_chain(200);
  PairForces beads{.name = "beads", .epsilon = 1e-3, .sigma = 0.01};
  for (int k = 0; k < 8; ++k) beads.points.push_back(scenes::add_point({0.1 * k, 5.0, 0.0}, &system));
  for (const double y : {6.0, 7.0, 8.0}) scenes::add_point({0.0, y, 0.0}, &system);
  system.forces.push_back(beads);
  return system;
}

/// Points that constraints or pair forces join are on one rank where islands are to be whole, and are cut elsewhere.
void check_whole_islands(Checks* checks) {
  System system = make_chain_and_beads();
  const int size = checks->ranks.size();
  const auto count_owners = [&](Islands islands, std::size_t first, std::size_t last) {
    const std::vector<int> owner = assign_owners(system, size, islands);
    std::vector<int> some(owner.begin() + static_cast<std::ptrdiff_t>(first),
                          owner.begin() + static_cast<std::ptrdiff_t>(last));
    std::ranges::sort(some);
    return std::unique(some.begin(), some.end()) - some.begin();
  };
  checks->expect(count_owners(Islands::MayBeCut, 1, 201) > 1, "a long chain is cut");
  checks->expect(count_owners(Islands::AreWhole, 1, 201) == 1, "a long chain is whole");
  checks->expect(count_owners(Islands::AreWhole, 201, 209) == 1, "beads that repel each other are whole");
  // Friction wants the same, unless it has no contact.
  Planes floor{.name = "floor", .points = {}, .normal = {0, 0, 1}, .offset = 0.0};
  system.constraints.push_back(floor);
  system.friction = {Coulomb{.name = "rust", .at = {"floor"}, .coefficient = 0.2}};
  checks->expect(count_owners(Islands::MayBeCut, 1, 201) > 1, "friction without contacts lets a chain be cut");
  std::get<Planes>(system.constraints.back()).points = {201};
  checks->expect(count_owners(Islands::MayBeCut, 1, 201) == 1, "where there is friction a chain is whole");
}

/// Graphs that METIS cannot count are refused by name.
void check_metis_counts(Checks* checks) {
  require_metis_counts(std::numeric_limits<std::int32_t>::max());
  std::string message;
  try {
    require_metis_counts(std::size_t{1} << 31);
  } catch (const InputError& error) {
    message = error.what();
  }
  checks->expect(message.find("METIS counts to 2147483647") != std::string::npos, "too many neighbours: " + message);
}

}  // namespace

int main(int argc, char** argv) {
  int provided = 0;
  MPI_Init_thread(&argc, &argv, MPI_THREAD_FUNNELED, &provided);
  int failures = 0;
  {
    MpiRanks ranks(MPI_COMM_WORLD);
    Checks checks{ranks};
    compare(&checks, "chain", scenes::make_chain(2000), options_of(Method::Dop853, 0.0), 0.0);
    compare(&checks, "net", scenes::make_net(30, 24), options_of(Method::Rattle, 1e-3), 0.01);
    compare(&checks, "net, dop853", scenes::make_net(9, 8), options_of(Method::Dop853, 0.0), 0.03);
    compare(&checks, "net, taylor", scenes::make_net(9, 8), options_of(Method::Taylor, 0.0), 0.03);
    compare(&checks, "lattice", scenes::make_lattice(7), options_of(Method::Rattle, 1e-3), 0.005);
    compare(&checks, "melt", scenes::make_melt(8), options_of(Method::Rattle, 2e-4), 0.01);
    compare_spread(&checks, scenes::make_net(20, 18));
    compare_spread(&checks, scenes::make_lattice(6));
    compare_clusters(&checks);
    check_checkpoints(&checks);
    check_joined_parts(&checks);
    check_pieces(&checks);
    check_whole_islands(&checks);
    check_metis_counts(&checks);
    failures = checks.failures;
  }
  MPI_Finalize();
  return failures > 0 ? 1 : 0;
}
