#include "mpi/program/together.hpp"

#include <fmt/format.h>

#include <stdexcept>

#include "cli/messages.hpp"

namespace tanor::mpi {

void do_together(MpiRanks& ranks, const std::function<void()>& work) {
  cli::Failure failure{cli::ExitCode::Done, {}};
  try {
    work();
  } catch (...) {
    failure = cli::describe_current_exception();
  }
  const int own = failure.code == cli::ExitCode::Done ? ranks.size() : ranks.rank();
  int from = 0;
  MPI_Allreduce(&own, &from, 1, MPI_INT, MPI_MIN, ranks.communicator());
  if (from == ranks.size()) return;
  MPI_Bcast(&failure.code, sizeof failure.code, MPI_BYTE, from, ranks.communicator());
  ranks.share(from, &failure.message);
  if (from > 0) failure.message = fmt::format("rank {}: {}", from, failure.message);
  if (failure.code == cli::ExitCode::BadInput) throw InputError("", failure.message);
  throw std::runtime_error(failure.message);
}

void do_on_first(MpiRanks& ranks, const std::function<void()>& work) {
  do_together(ranks, [&] {
    if (ranks.rank() == 0) work();
  });
}

}  // namespace tanor::mpi
