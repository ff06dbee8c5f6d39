#include "mpi/pieces.hpp"
#include "mpi/tanor_mpi.hpp"

namespace tanor {

MpiRanks::MpiRanks(MPI_Comm communicator, std::size_t most_replicated)
    : communicator_(communicator), most_replicated_(most_replicated) {
  MPI_Comm_rank(communicator, &rank_);
  MPI_Comm_size(communicator, &size_);
}

void MpiRanks::reduce(std::span<double> numbers, MPI_Op operation) {
  in_pieces(numbers, [&](double* first, int size) {
    MPI_Allreduce(MPI_IN_PLACE, first, size, MPI_DOUBLE, operation, communicator_);
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
  }
  MPI_Waitall(static_cast<int>(requests_.size()), requests_.data(), MPI_STATUSES_IGNORE);
}

}  // namespace tanor
