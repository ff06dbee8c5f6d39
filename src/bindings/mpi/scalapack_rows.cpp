#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

#include "mpi/tanor_mpi.hpp"

extern "C" {
int Csys2blacs_handle(MPI_Comm communicator);
void Cfree_blacs_system_handle(int handle);
void Cblacs_gridinit(int* context, const char* order, int rows, int columns);
void Cblacs_gridinfo(int context, int* rows, int* columns, int* row, int* column);
void Cblacs_gridexit(int context);
int numroc_(const int* n, const int* block, const int* process, const int* source, const int* num_processes);
void descinit_(int* descriptor, const int* rows, const int* columns, const int* row_block, const int* column_block,
               const int* row_source, const int* column_source, const int* context, const int* leading, int* info);
void pdpotrf_(const char* triangle, const int* n, double* a, const int* row, const int* column, const int* descriptor,
              int* info);
void pdpotrs_(const char* triangle, const int* n, const int* num_right_sides, const double* a, const int* row,
              const int* column, const int* descriptor, double* b, const int* b_row, const int* b_column,
              const int* b_descriptor, int* info);
}

namespace tanor {

namespace {

using Descriptor = std::array<int, 9>;
constexpr int block = 64, zero = 0, one = 1;

/// A grid of processes, as square as it can be. Processes that are left over take no part in it.
struct Grid {
  int context, rows = 1, columns = 1, row = -1, column = -1;

  explicit Grid(const MpiRanks& ranks) : context(Csys2blacs_handle(ranks.communicator())) {
    while ((rows + 1) * (rows + 1) <= ranks.size()) ++rows;
    columns = ranks.size() / rows;
    handle_ = context;
    Cblacs_gridinit(&context, "Row", rows, columns);
    int num_rows = 0, num_columns = 0;
    if (context >= 0) Cblacs_gridinfo(context, &num_rows, &num_columns, &row, &column);
  }
  ~Grid() {
    if (context >= 0) Cblacs_gridexit(context);
    Cfree_blacs_system_handle(handle_);
  }
  Grid(const Grid&) = delete;
  Grid& operator=(const Grid&) = delete;

  bool takes_part() const { return row >= 0; }
  int owner(int i, int j) const { return i / block % rows * columns + j / block % columns; }
  int local_row(int i) const { return i / (block * rows) * block + i % block; }
  int local_column(int j) const { return j / (block * columns) * block + j % block; }

 private:
  int handle_;
};

/// Shared rows whose matrix is spread over the ranks in blocks (ScaLAPACK, pdpotrf).
class ScalapackRows final : public SharedRows {
 public:
  ScalapackRows(MpiRanks& ranks, std::size_t num_rows, std::span<const std::size_t> own)
      : ranks_(ranks),
        grid_(ranks),
        n_(static_cast<int>(num_rows)),
        own_(own.begin(), own.end()),
        scale_(num_rows),
        x_(num_rows) {
    make_descriptors();
    agree_on_entries();
  }

  double factorize(std::span<const double> triangle) override {
    std::ranges::fill(scale_, 0.0);  // the diagonal is summed first
    auto entry = triangle.begin();
    for (std::size_t j = 0; j < own_.size(); entry += static_cast<std::ptrdiff_t>(own_.size() - j), ++j)
      scale_[own_[j]] = *entry;
    ranks_.sum(scale_);
    double least = 1.0;
    for (double& each : scale_) {
      least = std::min(least, each);
      if (!(each > 0.0 && std::isfinite(each))) return 0.0;
      each = 1.0 / std::sqrt(each);
    }
    spread(triangle);
    int info = 0;
    if (grid_.takes_part()) pdpotrf_("L", &n_, a_.data(), &one, &one, descriptor_.data(), &info);
    return std::min(find_condition(info), least);
  }

  void solve(std::span<double> x) override {
    std::ranges::fill(x_, 0.0);
    for (std::size_t k = 0; k < own_.size(); ++k) x_[own_[k]] = x[k];
    ranks_.sum(x_);
    const bool has_right_side = grid_.takes_part() && grid_.column == 0;
    const auto for_local_rows = [&](const auto& visit) {
      for (int i = 0; i < n_ && has_right_side; ++i)
        if (i / block % grid_.rows == grid_.row)
          visit(static_cast<std::size_t>(i), b_[static_cast<std::size_t>(grid_.local_row(i))]);
    };
    for_local_rows([&](std::size_t i, double& b) { b = scale_[i] * x_[i]; });
    int info = 0;
    if (grid_.takes_part()) {
      pdpotrs_("L", &n_, &one, a_.data(), &one, &one, descriptor_.data(), b_.data(), &one, &one,
               right_side_descriptor_.data(), &info);
    }
    std::ranges::fill(x_, 0.0);
    for_local_rows([&](std::size_t i, double& b) { x_[i] = scale_[i] * b; });
    ranks_.sum(x_);
    for (std::size_t k = 0; k < own_.size(); ++k) x[k] = x_[own_[k]];
  }

 private:
  void make_descriptors() {
    std::size_t size = 0;
    if (grid_.takes_part()) {
      num_local_rows_ = std::max(1, numroc_(&n_, &block, &grid_.row, &zero, &grid_.rows));
      const int num_columns = std::max(1, numroc_(&n_, &block, &grid_.column, &zero, &grid_.columns));
      size = static_cast<std::size_t>(num_local_rows_) * static_cast<std::size_t>(num_columns);
    }
    std::array<double, 1> largest{static_cast<double>(size)};
    ranks_.find_largest(largest);
    if (largest[0] > std::numeric_limits<int>::max())  // on all ranks alike
      throw std::runtime_error(std::to_string(n_) +
                               " equations join points of several ranks: the numbers of one rank's block are more than "
                               "ScaLAPACK counts; take fewer ranks, or another division");
    if (!grid_.takes_part()) return;
    int info = 0;
    descinit_(descriptor_.data(), &n_, &n_, &block, &block, &zero, &zero, &grid_.context, &num_local_rows_, &info);
    descinit_(right_side_descriptor_.data(), &n_, &one, &block, &block, &zero, &zero, &grid_.context, &num_local_rows_,
              &info);
    a_.resize(size);
    b_.resize(static_cast<std::size_t>(num_local_rows_));
  }

  /// Agrees once on who sends which entries to whom; later only the numbers are sent.
  void agree_on_entries() {
    const auto size = static_cast<std::size_t>(ranks_.size());
    std::vector<std::vector<double>> sent_places(size), places(size);  // row n + column
    for (auto* const lists : {&sent_, &received_}) lists->resize(size);
    sent_from_.resize(size);
    places_.resize(size);
    std::size_t entry = 0;
    for (std::size_t j = 0; j < own_.size(); ++j) {
      for (std::size_t i = j; i < own_.size(); ++i, ++entry) {
        const auto owner = static_cast<std::size_t>(grid_.owner(static_cast<int>(own_[i]), static_cast<int>(own_[j])));
        sent_places[owner].push_back(static_cast<double>(own_[i]) * n_ + static_cast<double>(own_[j]));
        sent_from_[owner].push_back(entry);
      }
    }
    std::vector<double> sent_counts(size), counts(size);
    std::vector<Ranks::Message> messages;
    for (std::size_t r = 0; r < size; ++r) {
      sent_counts[r] = static_cast<double>(sent_from_[r].size());
      messages.push_back({static_cast<int>(r), {&sent_counts[r], 1}, {&counts[r], 1}});
    }
    ranks_.exchange(messages);
    for (std::size_t r = 0; r < size; ++r) {
      sent_[r].resize(sent_from_[r].size());
      for (auto* const lists : {&received_, &places}) (*lists)[r].resize(static_cast<std::size_t>(counts[r]));
      messages[r] = {static_cast<int>(r), sent_places[r], places[r]};
      entries_.push_back({static_cast<int>(r), sent_[r], received_[r]});
    }
    ranks_.exchange(messages);
    for (std::size_t r = 0; r < size; ++r) {
      for (const double place : places[r]) {
        const auto i = static_cast<unsigned>(static_cast<long>(place) / n_),
                   j = static_cast<unsigned>(static_cast<long>(place) % n_);
        places_[r].push_back({i, j, static_cast<unsigned>(index_of(static_cast<int>(i), static_cast<int>(j)))});
      }
    }
  }

  void spread(std::span<const double> triangle) {
    for (std::size_t r = 0; r < sent_.size(); ++r)
      std::ranges::transform(sent_from_[r], sent_[r].begin(), [&](std::size_t entry) { return triangle[entry]; });
    ranks_.exchange(entries_);
    std::ranges::fill(a_, 0.0);
    for (std::size_t r = 0; r < received_.size(); ++r) {
      for (std::size_t k = 0; k < received_[r].size(); ++k) {
        const auto [i, j, index] = places_[r][k];
        a_[index] += scale_[i] * scale_[j] * received_[r][k];
      }
    }
  }

  /// Returns the place of an entry of the matrix in this rank's block.
  std::size_t index_of(int i, int j) const {
    return static_cast<std::size_t>(grid_.local_column(j)) * static_cast<std::size_t>(num_local_rows_) +
           static_cast<std::size_t>(grid_.local_row(i));
  }

  /// Estimates the condition from the pivots, as Cholesky does.
  double find_condition(int info) {
    std::array<double, 3> found{static_cast<double>(std::abs(info)), -std::numeric_limits<double>::max(), 0.0};
    for (int i = 0; i < n_ && info == 0; ++i) {
      if (grid_.owner(i, i) != ranks_.rank()) continue;
      const double pivot = a_[index_of(i, i)];
      found[1] = std::max(found[1], -pivot);
      found[2] = std::max(found[2], pivot);
    }
    ranks_.find_largest(found);
    const double ratio = -found[1] / found[2];
    return found[0] > 0.0 ? 0.0 : ratio * ratio;
  }

  MpiRanks& ranks_;
  Grid grid_;
  int n_, num_local_rows_ = 1;
  Descriptor descriptor_{}, right_side_descriptor_{};
  std::vector<std::size_t> own_;
  std::vector<double> scale_, x_, a_, b_;
  std::vector<std::vector<std::size_t>> sent_from_;           // [rank] entries of the own triangle
  std::vector<std::vector<double>> sent_, received_;          // [rank] entries
  std::vector<std::vector<std::array<unsigned, 3>>> places_;  // [rank] their rows, columns and places in a_
  std::vector<Ranks::Message> entries_;
};

}  // namespace

std::unique_ptr<SharedRows> MpiRanks::make_shared_rows(std::size_t num_rows, std::span<const std::size_t> own) {
  if (num_rows <= most_replicated_) return nullptr;
  if (num_rows > std::numeric_limits<int>::max())
    throw std::runtime_error(std::to_string(num_rows) +
                             " equations join points of several ranks; ScaLAPACK counts to " +
                             std::to_string(std::numeric_limits<int>::max()));
  return std::make_unique<ScalapackRows>(*this, num_rows, own);
}

}  // namespace tanor
