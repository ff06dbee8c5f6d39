#include "mpi/program/together.hpp"

#include <fmt/format.h>

#include <sstream>

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
  throw SomeRankFailed{failure};
}

void do_on_first(MpiRanks& ranks, const std::function<void()>& work) {
  do_together(ranks, [&] {
    if (ranks.rank() == 0) work();
  });
}

std::vector<std::string> gather_texts(MpiRanks& ranks, const std::string& own) {
  std::vector<std::string> texts;
  for (int rank = 0; rank < ranks.size(); ++rank) ranks.share(rank, &texts.emplace_back(own));
  return texts;
}

std::vector<std::vector<std::string>> gather_lines(MpiRanks& ranks, const std::vector<std::string>& own) {
  std::string text;
  for (const std::string& line : own) text += line + "\n";
  std::vector<std::vector<std::string>> lines;
  for (const std::string& each : gather_texts(ranks, text)) {
    std::istringstream stream(each);
    lines.emplace_back();
    for (std::string line; std::getline(stream, line);) lines.back().push_back(line);
  }
  return lines;
}

}  // namespace tanor::mpi
