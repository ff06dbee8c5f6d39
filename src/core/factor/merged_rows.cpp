#include "factor/merged_rows.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/groups.hpp"
#include "factor/triangular_rows.hpp"

namespace tanor::detail {

namespace {

/// Dense rows over some columns of C.
struct RowFront {
  std::vector<int> columns;  // increasing
  std::vector<double> rows;  // row by row, columns.size() each
  std::size_t num_rows = 0;
  int next = -1;  // the next front that waits at the same column, or -1
};

/// Fronts that wait at columns. The memory of a released front is used again.
class WaitingRoom {
 public:
  explicit WaitingRoom(std::size_t num_columns) : first_(num_columns, -1) {}

  /// Adds an empty front that waits at `column`.
  RowFront& add(std::size_t column) {
    if (free_ < 0) {
      free_ = static_cast<int>(fronts_.size());
      fronts_.emplace_back();
    }
    const int taken = free_;
    RowFront& front = fronts_[static_cast<std::size_t>(taken)];
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
      RowFront& front = fronts_[static_cast<std::size_t>(freed)];
      first_[column] = front.next;
      front.next = free_;
      free_ = freed;
    }
  }

 private:
  std::vector<RowFront> fronts_;
  std::vector<int> first_;  // [column]
  int free_ = -1;
};

/// An entry of C at a point.
struct EntryPlace {
  int column, entry;
};

/// Lists the entries of C at each point, by increasing column.
Groups<EntryPlace> group_by_point(const PointColumns& C) {
  return {static_cast<std::size_t>(C.num_points), [&](const auto& add) {
            for (std::size_t j = 0; j < C.num_columns(); ++j) {
              for (int k = C.start[j]; k < C.start[j + 1]; ++k)
                add(C.entries[static_cast<std::size_t>(k)].point, EntryPlace{static_cast<int>(j), k});
            }
          }};
}

/// Applies the Householder reflection to `rows` [num_rows x width], from row `first` on, that takes all of column c
/// into row `first`. Returns false and reduces nothing if the column is no longer than `tolerance` there. The row with
/// the largest number there comes first, so that rows of very different sizes keep their own digits (M. J. D. Powell,
/// J. K. Reid 1969).
bool reflect(double* rows, std::size_t num_rows, std::size_t width, std::size_t first, std::size_t c,
             double tolerance) {
  double square = 0.0;
  std::size_t largest = first;
  for (std::size_t i = first; i < num_rows; ++i) {
    square += rows[i * width + c] * rows[i * width + c];
    if (std::abs(rows[i * width + c]) > std::abs(rows[largest * width + c])) largest = i;
  }
  if (largest != first) std::swap_ranges(rows + first * width, rows + (first + 1) * width, rows + largest * width);
  const double length = std::sqrt(square);
  if (!(length > tolerance)) return false;
  // H = 1 - u u'/(length |u_1|), u = x + sign(x_1) length e_1; H x = -sign(x_1) length e_1
  double* const top = rows + first * width;
  const double signed_length = std::copysign(length, top[c]);
  top[c] += signed_length;
  const double factor = 1.0 / (signed_length * top[c]);
  for (std::size_t k = c + 1; k < width; ++k) {
    double along = 0.0;
    for (std::size_t i = first; i < num_rows; ++i) along += rows[i * width + c] * rows[i * width + k];
    along *= factor;
    for (std::size_t i = first; i < num_rows; ++i) rows[i * width + k] -= along * rows[i * width + c];
  }
  top[c] = -signed_length;
  for (std::size_t i = first + 1; i < num_rows; ++i) rows[i * width + c] = 0.0;
  return true;
}

/// Eliminates the columns of C from left to right, each with a dense front of the rows that begin there.
class RowMerger {
 public:
  RowMerger(const PointColumns& C, double tolerance)
      : C_(C),
        tolerance_(tolerance),
        by_point_(group_by_point(C)),
        waiting_(C.num_columns()),
        place_(C.num_columns(), -1) {
    rows_.columns.reserve(C.entries.size());
    rows_.values.reserve(C.entries.size());
    rows_.start.reserve(C.num_columns() + 1);
    R_.independent.reserve(C.num_columns());
  }

  TriangularFactor merge() {
    for (std::size_t j = 0; j < C_.num_columns(); ++j) {
      const std::size_t num_rows = list_columns(j);
      if (columns_.empty()) {
        R_.dependent.push_back(static_cast<int>(j));
        continue;
      }
      fill_front(j, num_rows);
      waiting_.release(j);
      reduce_front(j, num_rows);
      for (const int column : columns_) place_[static_cast<std::size_t>(column)] = -1;
    }
    rows_.write_columns(C_.num_columns(), &R_);
    return std::move(R_);
  }

 private:
  /// Lists the columns of the front at column j and the points whose rows begin there. Returns its number of rows.
  std::size_t list_columns(std::size_t j) {
    columns_.clear();
    own_.clear();
    std::size_t num_rows = 0;
    const auto include = [&](int column) {
      if (place_[static_cast<std::size_t>(column)] >= 0) return;
      place_[static_cast<std::size_t>(column)] = 0;
      columns_.push_back(column);
    };
    waiting_.for_each(j, [&](const RowFront& other) {
      for (const int column : other.columns) include(column);
      num_rows += other.num_rows;
    });
    for (int k = C_.start[j]; k < C_.start[j + 1]; ++k) {
      const int point = C_.entries[static_cast<std::size_t>(k)].point;
      if (by_point_[static_cast<std::size_t>(point)].front().column != static_cast<int>(j)) continue;
      own_.push_back(point);
      for (const auto& there : by_point_[static_cast<std::size_t>(point)]) include(there.column);
      num_rows += 3;
    }
    if (!std::ranges::is_sorted(columns_)) std::ranges::sort(columns_);
    for (std::size_t k = 0; k < columns_.size(); ++k)
      place_[static_cast<std::size_t>(columns_[k])] = static_cast<int>(k);
    return num_rows;
  }

  void fill_front(std::size_t j, std::size_t num_rows) {
    const std::size_t width = columns_.size();
    front_.assign(num_rows * width, 0.0);
    double* row = front_.data();
    const auto at = [&](int column) { return row + place_[static_cast<std::size_t>(column)]; };
    waiting_.for_each(j, [&](const RowFront& other) {
      const double* value = other.rows.data();
      for (std::size_t i = 0; i < other.num_rows; ++i, row += width) {
        for (const int column : other.columns) *at(column) = *value++;
      }
    });
    for (const int point : own_) {
      for (const auto& there : by_point_[static_cast<std::size_t>(point)]) {
        const Vec3 value = C_.entries[static_cast<std::size_t>(there.entry)].value;
        double* const first = at(there.column);
        first[0] = value.x;
        first[width] = value.y;
        first[2 * width] = value.z;
      }
      row += 3 * width;
    }
  }

  /// Reduces the front to a trapezoid: at most one row begins at each column. Column j is left out if it is short.
  void reduce_front(std::size_t j, std::size_t num_rows) {
    const std::size_t width = columns_.size();
    const bool is_independent = reflect(front_.data(), num_rows, width, 0, 0, tolerance_);
    const std::size_t first_left = is_independent ? 1 : 0;
    std::size_t end = first_left;
    for (std::size_t c = 1; c < width && end < num_rows; ++c) {
      if (reflect(front_.data(), num_rows, width, end, c, 0.0)) ++end;
    }
    if (is_independent) {
      R_.independent.push_back(static_cast<int>(j));
      rows_.columns.insert(rows_.columns.end(), columns_.begin(), columns_.end());
      rows_.values.insert(rows_.values.end(), front_.data(), front_.data() + width);
      rows_.end_row();
    } else {
      R_.dependent.push_back(static_cast<int>(j));
    }
    // The rows that are left, also those of a dependent column, belong to the other columns.
    if (end == first_left) return;
    RowFront& rest = waiting_.add(static_cast<std::size_t>(columns_[1]));
    rest.columns.assign(columns_.begin() + 1, columns_.end());
    rest.num_rows = end - first_left;
    for (std::size_t i = first_left; i < end; ++i) {
      for (std::size_t k = 1; k < width; ++k) rest.rows.push_back(front_[i * width + k]);
    }
  }

  const PointColumns& C_;
  const double tolerance_;
  const Groups<EntryPlace> by_point_;
  WaitingRoom waiting_;
  TriangularFactor R_;
  TriangularRows rows_;
  std::vector<int> columns_, place_;  // columns of the current front; column -> its place there, or -1
  std::vector<int> own_;              // points whose rows begin at the current column
  std::vector<double> front_;         // [num_rows x columns]
};

}  // namespace

SparseColumns PointColumns::expand() const {
  SparseColumns C;
  C.num_rows = 3 * num_points;
  C.rows.reserve(3 * entries.size());
  C.values.reserve(3 * entries.size());
  for (const auto& [point, value] : entries) {
    for (int c = 0; c < 3; ++c) C.rows.push_back(3 * point + c);
    C.values.insert(C.values.end(), {value.x, value.y, value.z});
  }
  C.start = start;
  for (int& first : C.start) first *= 3;
  return C;
}

TriangularFactor merge_rows(const PointColumns& C, double tolerance) {
  return RowMerger(C, tolerance).merge();
}

}  // namespace tanor::detail
