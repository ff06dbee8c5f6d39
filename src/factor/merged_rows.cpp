#include "factor/merged_rows.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace tanor {

namespace {

/// Dense rows over some columns of C.
struct Front {
  std::vector<int> columns;  // increasing
  std::vector<double> rows;  // row by row, columns.size() each
  int next = -1;             // another one that waits at the same column
};

/// Fronts that wait at columns; their memory goes from one to the next.
class WaitingRoom {
 public:
  explicit WaitingRoom(std::size_t num_columns) : first_(num_columns, -1) {}

  /// An empty front that waits at `column`.
  Front& add(std::size_t column) {
    if (free_ < 0) {
      free_ = static_cast<int>(fronts_.size());
      fronts_.emplace_back();
    }
    const int taken = free_;
    Front& front = fronts_[static_cast<std::size_t>(taken)];
    free_ = front.next;
    front.next = first_[column];
    first_[column] = taken;
    front.columns.clear();
    front.rows.clear();
    return front;
  }
  template <class Use>
  void for_each(std::size_t column, const Use& use) const {
    for (int k = first_[column]; k >= 0; k = fronts_[static_cast<std::size_t>(k)].next)
      use(fronts_[static_cast<std::size_t>(k)]);
  }
  void release(std::size_t column) {
    while (first_[column] >= 0) {
      const int freed = first_[column];
      Front& front = fronts_[static_cast<std::size_t>(freed)];
      first_[column] = front.next;
      front.next = free_;
      free_ = freed;
    }
  }

 private:
  std::vector<Front> fronts_;
  std::vector<int> first_;  // [column]
  int free_ = -1;
};

/// One list of all rows of C by their first columns.
struct Rows {
  std::vector<int> start, columns;  // CSR
  std::vector<double> values;
  std::vector<int> by_first, first_of;  // rows that begin at column j: by_first[first_of[j]] … first_of[j + 1]

  explicit Rows(const SparseColumns& C) {
    const auto num_rows = static_cast<std::size_t>(C.num_rows);
    const std::size_t d = C.num_columns();
    start.assign(num_rows + 1, 0);
    for (const int row : C.rows) ++start[static_cast<std::size_t>(row) + 1];
    std::partial_sum(start.begin(), start.end(), start.begin());
    columns.resize(C.rows.size());
    values.resize(C.rows.size());
    std::vector<int> next(start.begin(), start.end() - 1);
    for (std::size_t j = 0; j < d; ++j) {
      for (int k = C.start[j]; k < C.start[j + 1]; ++k) {
        const int slot = next[static_cast<std::size_t>(C.rows[static_cast<std::size_t>(k)])]++;
        columns[static_cast<std::size_t>(slot)] = static_cast<int>(j);
        values[static_cast<std::size_t>(slot)] = C.values[static_cast<std::size_t>(k)];
      }
    }
    first_of.assign(d + 1, 0);
    const auto first_column = [&](std::size_t row) {
      return static_cast<std::size_t>(columns[static_cast<std::size_t>(start[row])]);
    };
    for (std::size_t row = 0; row < num_rows; ++row) {
      if (start[row] < start[row + 1]) ++first_of[first_column(row) + 1];
    }
    std::partial_sum(first_of.begin(), first_of.end(), first_of.begin());
    by_first.resize(static_cast<std::size_t>(first_of.back()));
    next.assign(first_of.begin(), first_of.end() - 1);
    for (std::size_t row = 0; row < num_rows; ++row) {
      if (start[row] < start[row + 1])
        by_first[static_cast<std::size_t>(next[first_column(row)]++)] = static_cast<int>(row);
    }
  }
};

/// Takes rows in one by one and keeps them as an upper trapezoid: at most one row begins at each column.
class Trapezoid {
 public:
  /// For rows of `width` columns.
  void begin(std::size_t width) {
    width_ = width;
    row_at_.assign(width, none);
    values_.clear();
  }
  std::size_t width() const { return width_; }
  /// Rotates `row` [width] (which is used up) into the rows that are there.
  void take(double* row) {
    for (std::size_t c = 0; c < width_; ++c) {
      if (row[c] == 0.0) continue;
      if (row_at_[c] == none) {
        row_at_[c] = values_.size();
        values_.insert(values_.end(), row, row + width_);
        return;
      }
      // [cos sin; -sin cos] takes (a, b) at column c to (|(a, b)|, 0)
      double* const other = values_.data() + row_at_[c];
      const double length = std::sqrt(other[c] * other[c] + row[c] * row[c]), inverse = 1.0 / length;
      const double cosine = other[c] * inverse, sine = row[c] * inverse;
      other[c] = length;
      row[c] = 0.0;
      for (std::size_t k = c + 1; k < width_; ++k) {
        const double a = other[k], b = row[k];
        other[k] = cosine * a + sine * b;
        row[k] = cosine * b - sine * a;
      }
    }
  }
  /// The row that begins at column c; null where none does.
  const double* row_at(std::size_t c) const { return row_at_[c] == none ? nullptr : values_.data() + row_at_[c]; }

 private:
  static constexpr auto none = static_cast<std::size_t>(-1);
  std::size_t width_ = 0;
  std::vector<std::size_t> row_at_;  // [column] its place in values_
  std::vector<double> values_;
};

/// R row by row into columns; those of dependent columns are left out.
void write_columns(const std::vector<int>& row_start, const std::vector<int>& columns,
                   const std::vector<double>& values, std::size_t num_columns, TriangularFactor* R) {
  std::vector<int> place(num_columns, -1);
  for (std::size_t k = 0; k < R->rank(); ++k) place[static_cast<std::size_t>(R->independent[k])] = static_cast<int>(k);
  R->start.assign(R->rank() + 1, 0);
  for (const int column : columns) {
    if (const int k = place[static_cast<std::size_t>(column)]; k >= 0) ++R->start[static_cast<std::size_t>(k) + 1];
  }
  std::partial_sum(R->start.begin(), R->start.end(), R->start.begin());
  R->rows.resize(static_cast<std::size_t>(R->start.back()));
  R->values.resize(R->rows.size());
  std::vector<int> next(R->start.begin(), R->start.end() - 1);
  // Rows come in order, so that the diagonal is the last of its column.
  for (std::size_t row = 0; row < R->rank(); ++row) {
    for (int entry = row_start[row]; entry < row_start[row + 1]; ++entry) {
      const int k = place[static_cast<std::size_t>(columns[static_cast<std::size_t>(entry)])];
      if (k < 0) continue;
      const auto slot = static_cast<std::size_t>(next[static_cast<std::size_t>(k)]++);
      R->rows[slot] = static_cast<int>(row);
      R->values[slot] = values[static_cast<std::size_t>(entry)];
    }
  }
}

}  // namespace

TriangularFactor merge_rows(const SparseColumns& C, double tolerance) {
  const std::size_t d = C.num_columns();
  const Rows rows(C);
  TriangularFactor R;
  std::vector<int> row_start{0}, row_columns;  // of R
  std::vector<double> row_values;
  row_columns.reserve(C.rows.size() / 2);
  row_values.reserve(C.rows.size() / 2);
  row_start.reserve(d + 1);
  R.independent.reserve(d);
  WaitingRoom waiting(d);
  std::vector<int> columns, place(d, -1);  // of the front at hand; column -> its place there
  std::vector<double> row;
  Trapezoid trapezoid;

  for (std::size_t j = 0; j < d; ++j) {
    columns.clear();
    const auto include = [&](int column) {
      if (place[static_cast<std::size_t>(column)] >= 0) return;
      place[static_cast<std::size_t>(column)] = 0;
      columns.push_back(column);
    };
    const auto own = [&](const auto& use) {
      for (int k = rows.first_of[j]; k < rows.first_of[j + 1]; ++k) {
        const auto i = static_cast<std::size_t>(rows.by_first[static_cast<std::size_t>(k)]);
        for (int e = rows.start[i]; e < rows.start[i + 1]; ++e)
          use(e == rows.start[i], e + 1 == rows.start[i + 1], static_cast<std::size_t>(e));
      }
    };
    waiting.for_each(j, [&](const Front& front) { std::ranges::for_each(front.columns, include); });
    own([&](bool, bool, std::size_t e) { include(rows.columns[e]); });
    if (columns.empty()) {
      R.dependent.push_back(static_cast<int>(j));
      continue;
    }
    std::ranges::sort(columns);
    for (std::size_t k = 0; k < columns.size(); ++k) place[static_cast<std::size_t>(columns[k])] = static_cast<int>(k);
    const auto at = [&](int column) { return static_cast<std::size_t>(place[static_cast<std::size_t>(column)]); };

    trapezoid.begin(columns.size());
    waiting.for_each(j, [&](const Front& front) {
      for (std::size_t first = 0; first < front.rows.size(); first += front.columns.size()) {
        row.assign(columns.size(), 0.0);
        for (std::size_t k = 0; k < front.columns.size(); ++k) row[at(front.columns[k])] = front.rows[first + k];
        trapezoid.take(row.data());
      }
    });
    own([&](bool is_first, bool is_last, std::size_t e) {
      if (is_first) row.assign(columns.size(), 0.0);
      row[at(rows.columns[e])] = rows.values[e];
      if (is_last) trapezoid.take(row.data());
    });
    waiting.release(j);

    const double* const pivot = static_cast<std::size_t>(columns[0]) == j ? trapezoid.row_at(0) : nullptr;
    const bool is_independent = pivot != nullptr && std::abs(pivot[0]) > tolerance;
    if (is_independent) {
      R.independent.push_back(static_cast<int>(j));
      row_columns.insert(row_columns.end(), columns.begin(), columns.end());
      row_values.insert(row_values.end(), pivot, pivot + columns.size());
      row_start.push_back(static_cast<int>(row_columns.size()));
    } else {
      R.dependent.push_back(static_cast<int>(j));
    }
    // What a dependent column leaves of its row belongs to the others.
    Front* rest = nullptr;
    for (std::size_t c = is_independent ? 1 : 0; c < columns.size() && columns.size() > 1; ++c) {
      const double* const left = trapezoid.row_at(c);
      if (left == nullptr) continue;
      if (rest == nullptr) {
        rest = &waiting.add(static_cast<std::size_t>(columns[1]));
        rest->columns.assign(columns.begin() + 1, columns.end());
      }
      rest->rows.insert(rest->rows.end(), left + 1, left + columns.size());
    }
    for (const int column : columns) place[static_cast<std::size_t>(column)] = -1;
  }
  write_columns(row_start, row_columns, row_values, d, &R);
  return R;
}

}  // namespace tanor
