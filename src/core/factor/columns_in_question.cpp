#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <span>
#include <utility>

#include "base/groups.hpp"
#include "base/numbers.hpp"
#include "base/vec3.hpp"
#include "factor/dependent_columns.hpp"

namespace tanor::detail {

namespace {

/// The entries of a column in the three rows of a point.
struct Entry {
  int column;
  Vec3 part;
};

/// Calls visit(threes, part) for each triple of rows in which column j has entries.
template <class Visit>
void for_each_part(const SparseColumns& C, std::size_t j, const Visit& visit) {
  const auto end = static_cast<std::size_t>(C.start[j + 1]);
  for (auto e = static_cast<std::size_t>(C.start[j]); e < end;) {
    const int threes = C.rows[e] / 3;
    std::array<double, 3> part{};
    for (; e < end && C.rows[e] / 3 == threes; ++e) part[static_cast<std::size_t>(C.rows[e] % 3)] += C.values[e];
    visit(threes, make_vec3(part));
  }
}

class Search {
 public:
  Search(const SparseColumns& C, double tolerance)
      : C_(C), largest_bound_(1e-4 / tolerance), bound_(C.num_columns(), in_question) {
    entries_ = Groups<Entry>((static_cast<std::size_t>(C.num_rows) + 2) / 3, [&](const auto& add) {
      for (std::size_t j = 0; j < C.num_columns(); ++j)
        for_each_part(C, j, [&](int threes, Vec3 part) { add(threes, Entry{static_cast<int>(j), part}); });
    });
    for (std::size_t threes = 0; threes < entries_.size(); ++threes) {
      num_left_.push_back(entries_[threes].size());
      waiting_.push_back(static_cast<int>(threes));
    }
  }

  /// Visits the triples in the order in which they were reached, so that the bounds stay small.
  void run() {
    for (std::size_t next = 0; next < waiting_.size(); ++next) {
      const auto threes = static_cast<std::size_t>(waiting_[next]);
      if (num_left_[threes] > most_at_once) continue;
      for (const Entry& entry : entries_[threes]) {
        const auto column = static_cast<std::size_t>(entry.column);
        if (is_in_question(column)) settle(column, bound_of(entry, entries_[threes]));
      }
    }
  }

  std::vector<std::vector<int>> list_groups() {
    std::vector<std::vector<int>> groups;
    std::vector<char> is_listed(C_.num_columns(), 0);
    const auto list = [&](std::size_t column, std::vector<int>* group) {
      if (is_listed[column] != 0 || !is_in_question(column)) return;
      is_listed[column] = 1;
      group->push_back(static_cast<int>(column));
    };
    for (std::size_t j = 0; j < C_.num_columns(); ++j) {
      std::vector<int> group;
      list(j, &group);
      for (std::size_t head = 0; head < group.size(); ++head) {
        for_each_part(C_, static_cast<std::size_t>(group[head]), [&](int threes, Vec3) {
          std::size_t& left = num_left_[static_cast<std::size_t>(threes)];
          if (std::exchange(left, 0) == 0) return;
          for (const Entry& entry : entries_[static_cast<std::size_t>(threes)])
            list(static_cast<std::size_t>(entry.column), &group);
        });
      }
      if (group.empty()) continue;
      std::ranges::sort(group);
      groups.push_back(std::move(group));
    }
    return groups;
  }

 private:
  static constexpr double in_question = -1.0;
  static constexpr std::size_t most_at_once = 8;  // with more columns at once, their directions leave none out

  bool is_in_question(std::size_t column) const { return bound_[column] < 0.0; }

  void settle(std::size_t column, double bound) {
    if (!(bound <= largest_bound_)) return;
    bound_[column] = bound;
    for_each_part(C_, column, [&](int threes, Vec3) {
      --num_left_[static_cast<std::size_t>(threes)];
      waiting_.push_back(threes);
    });
  }

  /// Returns |x_p| <= (|v| |C x| + sum over settled q of |v'c_q| |x_q|)/v'v, which holds because v'c_p = v'v.
  double bound_of(const Entry& own, std::span<const Entry> all) const {
    const Vec3 v = find_normal(own, all);
    double sum = norm(v);
    for (const auto& [column, part] : all) {
      const double bound = bound_[static_cast<std::size_t>(column)];
      if (bound >= 0.0) sum += std::abs(dot(v, part)) * bound;
    }
    return sum / squared(v);
  }

  /// Returns the component of `own` that is orthogonal to the parts of others in question: 0 or rounding if these span
  /// it.
  Vec3 find_normal(const Entry& own, std::span<const Entry> all) const {
    std::array<Vec3, 2> basis;
    std::size_t rank = 0;
    const auto project = [&](Vec3 part) {
      // The second pass removes the rounding of the first.
      for (std::size_t pass = 0; pass < 2; ++pass) {
        for (std::size_t k = 0; k < rank; ++k) part = part - dot(part, basis[k]) * basis[k];
      }
      return part;
    };
    for (const Entry& other : all) {
      if (other.column == own.column || !is_in_question(static_cast<std::size_t>(other.column))) continue;
      const Vec3 part = project(other.part);
      const double length = norm(part);
      if (length <= 16.0 * eps * norm(other.part)) continue;
      if (rank == basis.size()) return {};
      basis[rank++] = (1.0 / length) * part;
    }
    return project(own.part);
  }

  const SparseColumns& C_;
  const double largest_bound_;
  std::vector<double> bound_;          // [column] bound of |x| over |C x|
  Groups<Entry> entries_;              // [threes]
  std::vector<std::size_t> num_left_;  // [threes] number of columns in question
  std::vector<int> waiting_;
};

}  // namespace

std::vector<std::vector<int>> find_columns_in_question(const SparseColumns& C, double tolerance) {
  Search search(C, tolerance);
  search.run();
  return search.list_groups();
}

}  // namespace tanor::detail
