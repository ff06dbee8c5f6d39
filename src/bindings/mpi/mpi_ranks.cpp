#include "mpi/pieces.hpp"
#include "mpi/scalapack_rows.hpp"
#include "mpi/tanor_mpi.hpp"

namespace tanor {

MpiRanks::MpiRanks(MPI_Comm communicator, std::size_t most_replicated)
    : communicator_(communicator), most_replicated_(most_replicated) {
  MPI_Comm_rank(communicator, &rank_);
  MPI_Comm_size(communicator, &size_);
}

void MpiRanks::count(const Traffic& more) {
  traffic_.reductions += more.reductions;
  traffic_.reduced_bytes += more.reduced_bytes;
  traffic_.messages += more.messages;
  traffic_.message_bytes += more.message_bytes;
}

void MpiRanks::sum(std::span<double> numbers) {
  count({.reductions = 1, .reduced_bytes = 8 * numbers.size()});
  in_pieces(numbers, [&](double* first, int size) {
    MPI_Allreduce(MPI_IN_PLACE, first, size, MPI_DOUBLE, MPI_SUM, communicator_);
  });
}

void MpiRanks::find_largest(std::span<double> numbers) {
  count({.reductions = 1, .reduced_bytes = 8 * numbers.size()});
  in_pieces(numbers, [&](double* first, int size) {
    MPI_Allreduce(MPI_IN_PLACE, first, size, MPI_DOUBLE, MPI_MAX, communicator_);
  });
}

void MpiRanks::share(int from, std::string* text) {
  auto size = static_cast<unsigned long>(text->size());
  MPI_Bcast(&size, 1, MPI_UNSIGNED_LONG, from, communicator_);
  text->resize(size);
  in_pieces(std::span(*text), [&](char* first, int count) { MPI_Bcast(first, count, MPI_CHAR, from, communicator_); });
}

void MpiRanks::exchange(std::span<const Message> messages) {
  constexpr int tag = 17;
  requests_.clear();
  for (const Message& message : messages) {
    in_pieces(message.received, [&](double* first, int size) {
      MPI_Irecv(first, size, MPI_DOUBLE, message.rank, tag, communicator_, &requests_.emplace_back());
    });
    in_pieces(message.sent, [&](const double* first, int size) {
      MPI_Isend(first, size, MPI_DOUBLE, message.rank, tag, communicator_, &requests_.emplace_back());
    });
    count({.messages = 1, .message_bytes = 8 * message.sent.size()});
  }
  MPI_Waitall(static_cast<int>(requests_.size()), requests_.data(), MPI_STATUSES_IGNORE);
}

std::unique_ptr<SharedRows> MpiRanks::make_shared_rows(std::size_t num_rows, std::span<const std::size_t> own) {
  if (num_rows <= most_replicated_) return nullptr;
  return make_scalapack_rows(*this, num_rows, own);
}

}  // namespace tanor
