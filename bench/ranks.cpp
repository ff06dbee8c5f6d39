/// Solves S lambda = -b of one island on the ranks of MPI, against one rank: the rows that are left to eliminate, the
/// traffic between ranks, and the difference of the answers.
///
///   mpirun -n P bench_ranks chain|net|lattice SIZE [strips] [REPETITIONS]
///
/// chain: SIZE points; net, lattice: SIZE points a side, somewhat disturbed, masses 0.7 to 1.3. METIS cuts the points,
/// or
/// with `strips` planes across the longest axis do. Times are processor time of the thread, medians.

#include <time.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <random>
#include <string>
#include <vector>

#include "dynamics/workspace.hpp"
#include "mpi/tanor_mpi.hpp"
#include "ranks/cut_factor.hpp"
#include "schur/gram_solver.hpp"

namespace {

using namespace tanor;
using namespace tanor::detail;

double thread_seconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

double median(std::vector<double> values) {
  std::ranges::sort(values);
  return values[values.size() / 2];
}

System make_system(const std::string& kind, int size) {
  System system;
  std::mt19937 random(3);
  std::uniform_real_distribution<double> any(-0.1, 0.1), mass(0.7, 1.3);
  const int nx = size, ny = kind == "chain" ? 1 : size, nz = kind == "lattice" ? size : 1;
  Rods rods;
  const auto number = [&](int x, int y, int z) { return static_cast<Index>((x * ny + y) * nz + z); };
  for (int x = 0; x < nx; ++x) {
    for (int y = 0; y < ny; ++y) {
      for (int z = 0; z < nz; ++z) {
        for (const int place : {x, y, z}) system.positions.push_back(place + any(random));
        system.masses.push_back(mass(random));
        if (x > 0) rods.pairs.push_back({number(x - 1, y, z), number(x, y, z)});
        if (y > 0) rods.pairs.push_back({number(x, y - 1, z), number(x, y, z)});
        if (z > 0) rods.pairs.push_back({number(x, y, z - 1), number(x, y, z)});
      }
    }
  }
  system.constraints = {rods};
  return system;
}

/// Work that a rank's own elimination does not count, and the bytes that it hands over.
struct Shared {
  double seconds = 0.0;
  std::size_t bytes = 0;
};

/// Times the work on the shared rows. Where the ranks spread them, each sends its triangle.
class TimedRows final : public SharedRows {
 public:
  TimedRows(std::unique_ptr<SharedRows> rows, bool are_spread, Shared* shared)
      : rows_(std::move(rows)), are_spread_(are_spread), shared_(shared) {}
  double factorize(std::span<const double> triangle) override {
    const double begin = thread_seconds();
    const double found = rows_->factorize(triangle);
    shared_->seconds += thread_seconds() - begin;
    if (are_spread_) shared_->bytes += 8 * triangle.size();
    return found;
  }
  void solve(std::span<double> x) override { rows_->solve(x); }

 private:
  std::unique_ptr<SharedRows> rows_;
  bool are_spread_;
  Shared* shared_;
};

class TimedRanks final : public Ranks {
 public:
  explicit TimedRanks(MpiRanks& ranks) : ranks_(ranks) {}
  int rank() const override { return ranks_.rank(); }
  int size() const override { return ranks_.size(); }
  void sum(std::span<double> numbers) override {
    shared.bytes += 8 * numbers.size();
    ranks_.sum(numbers);
  }
  void find_largest(std::span<double> numbers) override {
    shared.bytes += 8 * numbers.size();
    ranks_.find_largest(numbers);
  }
  void share(int from, std::string* text) override { ranks_.share(from, text); }
  void exchange(std::span<const Message> messages) override {
    for (const Message& message : messages) shared.bytes += 8 * message.sent.size();
    ranks_.exchange(messages);
  }
  std::unique_ptr<SharedRows> make_shared_rows(std::size_t num_rows, std::span<const std::size_t> own) override {
    std::unique_ptr<SharedRows> rows = ranks_.make_shared_rows(num_rows, own);
    const bool are_spread = rows != nullptr;
    if (!are_spread) rows = make_replicated_rows(*this, num_rows, own, 1);
    return std::make_unique<TimedRows>(std::move(rows), are_spread, &shared);
  }
  Shared shared;

 private:
  MpiRanks& ranks_;
};

double any_number(std::size_t equation) {
  return std::sin(1.7 * static_cast<double>(equation) + 0.3);
}

struct Serial {
  std::vector<double> x;  // [equation]
  double factor_seconds = 0.0, solve_seconds = 0.0;
};

Serial solve_alone(const System& system, int repetitions) {
  Workspace work(system, {.threads = 1}, 0.0);
  const Model& model = work.model();
  std::vector<double> blocks(3 * work.constraints.num_blocks()), r(3 * model.num_points()), b(model.num_rows()), x = b;
  model.numbering.gather_points(system.positions, r);
  work.constraints.evaluate_gradients(model.parallel, r.data(), blocks.data());
  GramSolver solver(model.incidences, model.inverse_mass, model.numbering, Ordering::Auto, {});
  for (std::size_t a = 0; a < b.size(); ++a) b[a] = any_number(static_cast<std::size_t>(model.numbering.user_row[a]));
  std::vector<double> factor, solve;
  for (int k = 0; k < repetitions; ++k) {
    double begin = thread_seconds();
    solver.assemble(model.parallel, blocks.data());
    (void)solver.factorize(model.parallel);
    factor.push_back(thread_seconds() - begin);
    begin = thread_seconds();
    solver.solve_negative(model.parallel, b.data(), x.data());
    solve.push_back(thread_seconds() - begin);
  }
  Serial result{std::vector<double>(b.size()), median(factor), median(solve)};
  model.numbering.scatter_rows(x, result.x);
  return result;
}

std::vector<int> cut_in_strips(const System& system, int num_ranks) {
  double longest = 0.0;
  for (std::size_t i = 0; i < system.num_points(); ++i)
    longest = std::max(longest, std::round(system.positions[3 * i]));
  std::vector<int> owner;
  for (std::size_t i = 0; i < system.num_points(); ++i)
    owner.push_back(static_cast<int>(std::round(system.positions[3 * i]) * num_ranks / (longest + 1.0)));
  return owner;
}

void measure(MpiRanks& ranks, const std::string& kind, int size, bool in_strips, int repetitions) {
  const System system = make_system(kind, size);
  const Serial serial = solve_alone(system, repetitions);
  TimedRanks timed(ranks);
  const std::vector<int> owner = in_strips ? cut_in_strips(system, ranks.size()) : assign_owners(system, ranks.size());
  const RankSystem own = take_part(system, owner, timed);
  Workspace work(own.system, {.threads = 1}, 0.0);
  const Model& model = work.model();
  std::vector<double> blocks(3 * work.constraints.num_blocks()), r(3 * model.num_points()), b(model.num_rows()), x = b;
  model.numbering.gather_points(own.system.positions, r);
  work.constraints.evaluate_gradients(model.parallel, r.data(), blocks.data());
  const auto equation = [&](std::size_t a) {
    return own.equations[static_cast<std::size_t>(model.numbering.user_row[a])];
  };
  for (std::size_t a = 0; a < b.size(); ++a) b[a] = any_number(equation(a));
  CutFactor solver(work, own.part, {.threads = 1}, blocks);
  std::vector<double> factor, solve;
  std::size_t factor_bytes = 0, solve_bytes = 0;
  for (int k = 0; k < repetitions; ++k) {
    MPI_Barrier(ranks.communicator());
    timed.shared.seconds = 0.0;
    std::size_t before = timed.shared.bytes;
    double begin = thread_seconds();
    (void)solver.factorize(0.0, r.data());
    factor.push_back(thread_seconds() - begin - timed.shared.seconds);
    factor_bytes = timed.shared.bytes - before;
    before = timed.shared.bytes;
    begin = thread_seconds();
    solver.solve_negative(model.parallel, b.data(), x.data());
    solve.push_back(thread_seconds() - begin);
    solve_bytes = timed.shared.bytes - before;
  }
  double error = 0.0, largest = 0.0;
  for (std::size_t a = 0; a < x.size(); ++a) error = std::max(error, std::abs(x[a] - serial.x[equation(a)]));
  for (const double each : serial.x) largest = std::max(largest, std::abs(each));
  double numbers[4] = {median(factor), median(solve), error / largest, -serial.factor_seconds};
  ranks.find_largest(numbers);
  if (ranks.rank() != 0) return;
  const auto g = static_cast<double>(own.part.num_shared_rows);
  const double triangle = 4.0 * g * (g + 1.0);
  std::printf(
      "%s %d%s on %d ranks: %zu rows, %.0f shared | own elimination %.2f ms, serial %.2f ms (%.2f) | "
      "factorization sends %zu B (%.2f of the triangle), solve %zu B | error %.1e, iterations 0\n",
      kind.c_str(), size, in_strips ? " in strips" : "", ranks.size(), serial.x.size(), g, 1e3 * numbers[0],
      -1e3 * numbers[3], numbers[0] / -numbers[3], factor_bytes,
      triangle > 0.0 ? static_cast<double>(factor_bytes) / triangle : 0.0, solve_bytes, numbers[2]);
}

}  // namespace

int main(int argc, char** argv) {
  MPI_Init(&argc, &argv);
  if (argc >= 3) {
    MpiRanks ranks(MPI_COMM_WORLD);
    const bool in_strips = argc > 3 && std::string(argv[3]) == "strips";
    const int last = in_strips ? 4 : 3;
    measure(ranks, argv[1], std::atoi(argv[2]), in_strips, argc > last ? std::atoi(argv[last]) : 7);
  }
  MPI_Finalize();
  return argc >= 3 ? 0 : 2;
}
