#include <algorithm>
#include <cmath>
#include <limits>
#include <type_traits>

#include "base/instruction_sets.hpp"
#include "factor/front_lanes.hpp"
#include "plan/thresholds.hpp"

namespace tanor::detail::kernels {

namespace {

constexpr std::size_t depth = plan::terms_of_product;
static_assert(depth % front_width == 0 && front_width == 2 * tile,
              "a tile begins at the first lane of a register or in its middle");

/// A block of a front, with whole lanes of rows.
struct FrontBlock {
  std::size_t rows, columns;
  bool is_lower = false;  // true if entries above the diagonal are not needed
  bool is_fresh = false;  // true if they count as 0 before
};

/// Computes c_ij -= sum over k of a_ik b_jk for `lanes` x 8 rows and `columns` columns, or c = -… if c is fresh. The
/// sums stay in registers; if there are too few, the tile is split and its parts are done one after the other.
template <class Lanes, std::size_t lanes, std::size_t columns, bool fresh>
[[gnu::always_inline]] inline void subtract_tile(std::size_t terms, const double* a, const double* b,
                                                 std::size_t stride, double* c, std::size_t c_stride) {
  if constexpr (lanes * columns > Lanes::most_in_registers && lanes > 1) {
    constexpr std::size_t some = lanes / 2, first = front_width * some;
    subtract_tile<Lanes, some, columns, fresh>(terms, a, b, stride, c, c_stride);
    subtract_tile<Lanes, lanes - some, columns, fresh>(terms, a + first, b, stride, c + first, c_stride);
  } else if constexpr (columns > Lanes::most_in_registers) {
    constexpr std::size_t some = columns / 2;
    subtract_tile<Lanes, lanes, some, fresh>(terms, a, b, stride, c, c_stride);
    subtract_tile<Lanes, lanes, columns - some, fresh>(terms, a, b + some, stride, c + some * c_stride, c_stride);
  } else {
    Lanes sum[columns][lanes];
    for (std::size_t j = 0; j < columns; ++j) {
      for (std::size_t i = 0; i < lanes; ++i)
        sum[j][i] = fresh ? Lanes{} : Lanes::at(c + j * c_stride + front_width * i);
    }
    for (std::size_t k = 0; k < terms; ++k, a += stride, b += stride) {
      Lanes a_k[lanes];
      for (std::size_t i = 0; i < lanes; ++i) a_k[i] = Lanes::at(a + front_width * i);
      for (std::size_t j = 0; j < columns; ++j) {
        for (std::size_t i = 0; i < lanes; ++i) sum[j][i] -= b[j] * a_k[i];
      }
    }
    for (std::size_t j = 0; j < columns; ++j) {
      for (std::size_t i = 0; i < lanes; ++i) sum[j][i].write(c + j * c_stride + front_width * i);
    }
  }
}

/// Computes c -= a b' for whole lanes of rows, `wide` columns at once; 24 rows at a time stay in the first cache.
template <class Lanes, std::size_t lanes, std::size_t wide, bool fresh>
[[gnu::always_inline]] inline void subtract_slices(const FrontBlock& block, std::size_t terms, const double* a,
                                                   const double* b, std::size_t stride, double* c, std::size_t c_stride,
                                                   std::size_t i, std::size_t end) {
  for (; i + lanes * front_width <= end; i += lanes * front_width) {
    const std::size_t columns = block.is_lower ? std::min(block.columns, i + lanes * front_width) : block.columns;
    std::size_t j = 0;
    for (; j + wide <= columns; j += wide)
      subtract_tile<Lanes, lanes, wide, fresh>(terms, a + i, b + j, stride, c + j * c_stride + i, c_stride);
    for (; j < columns; j += tile) {
      with_columns(
          columns - j, [&](auto count) __attribute__((always_inline)) {
            subtract_tile<Lanes, lanes, count, fresh>(terms, a + i, b + j, stride, c + j * c_stride + i, c_stride);
          });
    }
  }
  if constexpr (lanes > 1) {
    if (i < end) subtract_slices<Lanes, lanes - 1, wide, fresh>(block, terms, a, b, stride, c, c_stride, i, end);
  }
}

/// Does the same for all rows of a block, some terms at a time.
template <class Lanes>
[[gnu::always_inline]] inline void subtract_all(const FrontBlock& block, std::size_t terms, const double* a,
                                                const double* b, std::size_t stride, double* c, std::size_t c_stride) {
  for (std::size_t k = 0; k < terms; k += depth, a += depth * stride, b += depth * stride) {
    const std::size_t some = std::min(depth, terms - k);
    if (block.is_fresh && k == 0) {
      subtract_slices<Lanes, 3, 8, true>(block, some, a, b, stride, c, c_stride, 0, block.rows);
    } else {
      subtract_slices<Lanes, 3, 8, false>(block, some, a, b, stride, c, c_stride, 0, block.rows);
    }
  }
}

/// The factor L of a few columns by a few rows. Its reciprocal pivots multiply everything in advance, so that one
/// operation leads from each x_k to the next one.
template <std::size_t columns>
struct TileFactor {
  double l[columns][columns];        // [row][column]
  double inverse[columns];           // 1/l_qq
  double divided[columns][columns];  // l_qk/l_qq

  [[gnu::always_inline]] void divide() {
    for_constants<columns>([&](auto q) __attribute__((always_inline)) {
      for_constants<q>([&](auto k) __attribute__((always_inline)) { divided[q][k] = l[q][k] * inverse[q]; });
    });
  }
};

/// Computes x := x l'^-1 for the rows at `rows`, as many as a register has lanes, in columns that stand a stride apart.
template <class Lanes, std::size_t columns>
[[gnu::always_inline]] inline void divide_lanes(const TileFactor<columns>& by, std::size_t stride, const double* rows,
                                                Lanes (&x)[columns]) {
  for_constants<columns>([&](auto q) __attribute__((always_inline)) {
    x[q] = by.inverse[q] * Lanes::at(rows + q * stride);
    for_constants<q>([&](auto k) __attribute__((always_inline)) { x[q] -= by.divided[q][k] * x[k]; });
  });
}

/// Does the same for the rows [first, end) in whole lanes, in place.
template <class Lanes, std::size_t columns>
[[gnu::always_inline]] inline void divide_rows(const TileFactor<columns>& by, std::size_t first, std::size_t end,
                                               std::size_t stride, double* rows) {
  for (std::size_t i = first; i < end; i += front_width) {
    Lanes x[columns];
    divide_lanes<Lanes, columns>(by, stride, rows + i, x);
    for_constants<columns>([&](auto q) __attribute__((always_inline)) { x[q].write(rows + q * stride + i); });
  }
}

/// Adds the rows of column j. Long columns are added in whole lanes where their rows follow each other in the front.
template <class Lanes>
[[gnu::always_inline]] inline void add_column(std::size_t j, const Tile& part, const ChildUpdate& child,
                                              const double* column, double* sum) {
  const std::size_t low = std::max(part.row, j);
  if (part.end_row < low + plan::long_column) {
    for (std::size_t i = low; i < part.end_row; ++i) sum[child.in_parent[i]] += column[i];
    return;
  }
  for (std::size_t i = low; i < part.end_row;) {
    const std::size_t stop = std::min(part.end_row, static_cast<std::size_t>(child.run_end[i]));
    double* const to = sum + child.in_parent[i];
    if (i + front_width <= stop) {
      (Lanes::at(to) + Lanes::at(column + i)).write(to);
      i += front_width;
    } else {
      *to += column[i++];
    }
  }
}

/// Adds a part of a child's update, whose columns stand a stride apart within a block.
template <class Lanes>
[[gnu::always_inline]] inline void add_columns(const Tile& part, const ChildUpdate& child, const FrontNumbers& front) {
  for (std::size_t j = part.column; j < part.end_column;) {
    const std::size_t stop = std::min(part.end_column, (j / Triangle::width + 1) * Triangle::width);
    const std::size_t stride = child.update.stride_of(j);
    for (const double* column = child.update.column(j); j < stop; ++j, column += stride)
      add_column<Lanes>(j, part, child, column, front.column(static_cast<std::size_t>(child.in_parent[j])));
  }
}

/// Factorizes the symmetric tile at c. Returns the first column without a positive pivot, or `columns`. The pivots d
/// come one after the other from L D L', which takes a division each; their roots are independent of each other.
template <std::size_t columns>
[[gnu::always_inline]] inline std::size_t factorize_square(const double* c, std::size_t stride,
                                                           TileFactor<columns>* factor) {
  auto& l = factor->l;
  double reciprocal[columns];
  std::size_t failed = columns;
  for_constants<columns>([&](auto q) __attribute__((always_inline)) {
    for_constants<columns - q>([&](auto below) __attribute__((always_inline)) {
      constexpr std::size_t p = q + below;
      l[p][q] = c[q * stride + p];
      for_constants<q>([&](auto k) __attribute__((always_inline)) { l[p][q] -= l[p][k] * (l[q][k] * reciprocal[k]); });
    });
    // The reciprocal of a denormal number would be infinite.
    if (!(l[q][q] >= std::numeric_limits<double>::min()) && failed == columns) failed = q;
    reciprocal[q] = 1.0 / l[q][q];
  });
  for_constants<columns>([&](auto q) __attribute__((always_inline)) {
    const double root = std::sqrt(l[q][q]);
    factor->inverse[q] = root * reciprocal[q];
    l[q][q] = root;
    for_constants<columns - q - 1>([&](auto below)
                                       __attribute__((always_inline)) { l[q + 1 + below][q] *= factor->inverse[q]; });
  });
  factor->divide();
  return failed;
}

/// Writes the lanes that hold the tile: 0 above its diagonal, L in it, and x below. The tile begins at lane `first`.
template <class Lanes, std::size_t columns, std::size_t first>
[[gnu::always_inline]] inline void write_tile(const TileFactor<columns>& factor, const Lanes (&x)[columns],
                                              std::size_t stride, double* c) {
  for_constants<columns>([&](auto q) __attribute__((always_inline)) {
    Lanes own{};
    for_constants<columns - q>([&](auto below) __attribute__((always_inline)) {
      own = own.template with<first + q + below>(factor.l[q + below][q]);
    });
    own.blended_with(x[q], [](std::size_t lane) { return lane >= first + columns; }).write(c + q * stride);
  });
}

/// Computes L of the columns j … j + columns - 1, from which all columns before them have been subtracted. `failed`
/// becomes the first column whose pivot is not positive, if there is one.
template <class Lanes, std::size_t columns>
[[gnu::always_inline]] inline void factorize_few(std::size_t j, std::size_t rows, std::size_t stride, double* panel,
                                                 std::size_t* failed) {
  double* const c = panel + j * stride;
  TileFactor<columns> factor;
  if (const std::size_t q = factorize_square<columns>(c + j, stride, &factor); q < columns)
    return void(*failed = j + q);
  const std::size_t begin = lanes_of(j);
  Lanes x[columns];
  divide_lanes<Lanes, columns>(factor, stride, c + begin, x);
  if (begin == j)
    write_tile<Lanes, columns, 0>(factor, x, stride, c + begin);
  else
    write_tile<Lanes, columns, tile>(factor, x, stride, c + begin);
  divide_rows<Lanes, columns>(factor, begin + front_width, rows, stride, c);
}

/// Computes L of the first columns. Returns the first column without a positive pivot, or `columns`.
template <class Lanes>
[[gnu::always_inline]] inline std::size_t factorize_columns(std::size_t columns, std::size_t rows, std::size_t stride,
                                                            double* panel) {
  std::size_t failed = columns;
  for (std::size_t first = 0; first < columns; first += depth) {
    const std::size_t end = std::min(columns, first + depth);
    for (std::size_t j = first; j < end && failed == columns; j += tile) {
      with_columns(
          end - j, [&](auto count) __attribute__((always_inline)) {
            const double* const before = panel + first * stride;
            subtract_slices<Lanes, 2, count, false>({rows, count}, j - first, before, before + j, stride,
                                                    panel + j * stride, stride, lanes_of(j), rows);
            factorize_few<Lanes, count>(j, rows, stride, panel, &failed);
          });
    }
    if (failed < columns) return failed;
    const double* const rest = panel + first * stride + end;
    subtract_all<Lanes>({lanes_of(rows - end + front_width - 1), columns - end, true}, end - first, rest, rest, stride,
                        panel + end * stride + end, stride);
  }
  return columns;
}

/// Computes x := x L11'^-1 with x [rows, columns] and L11 in `diagonal`.
template <class Lanes>
[[gnu::always_inline]] inline void divide_columns(std::size_t columns, std::size_t rows, const double* diagonal,
                                                  std::size_t stride, double* x) {
  for (std::size_t first = 0; first < columns; first += depth) {
    const std::size_t end = std::min(columns, first + depth);
    for (std::size_t j = first; j < end; j += tile) {
      with_columns(
          end - j, [&](auto count) __attribute__((always_inline)) {
            subtract_slices<Lanes, 2, count, false>({rows, count}, j - first, x + first * stride,
                                                    diagonal + first * stride + j, stride, x + j * stride, stride, 0,
                                                    rows);
            TileFactor<count> factor;
            for (std::size_t q = 0; q < count; ++q) {
              for (std::size_t p = q; p < count; ++p) factor.l[p][q] = diagonal[(j + q) * stride + j + p];
              factor.inverse[q] = 1.0 / factor.l[q][q];
            }
            factor.divide();
            divide_rows<Lanes, count>(factor, 0, rows, stride, x + j * stride);
          });
    }
    if (end == columns) return;
    subtract_slices<Lanes, 3, 8, false>({rows, columns - end}, end - first, x + first * stride,
                                        diagonal + first * stride + end, stride, x + end * stride, stride, 0, rows);
  }
}

/// Adds the updates of the children to a tile of the front, whose columns are all in the panel or all below.
template <class Lanes>
[[gnu::always_inline]] inline void add_children(const FrontNumbers& front, const Tile& part) {
  for (const ChildUpdate& child : front.children) {
    // Returns how many of its rows come before a row of the front.
    const auto place = [&](std::size_t row) {
      if (row == 0 || row == front.columns) return row == 0 ? row : child.rows_in_panel;
      const int* const end = child.in_parent + child.rows;
      if (static_cast<int>(row) > end[-1]) return child.rows;
      return static_cast<std::size_t>(std::lower_bound(child.in_parent, end, static_cast<int>(row)) - child.in_parent);
    };
    add_columns<Lanes>({place(part.row), place(part.end_row), place(part.column), place(part.end_column)}, child,
                       front);
  }
}

}  // namespace

void add_updates(const FrontNumbers& front, const Tile& part) {
  dispatch([=]<class Lanes>(std::type_identity<Lanes>) { add_children<Lanes>(front, part); });
}

std::size_t eliminate(const FrontNumbers& front, const Tile& panel, const Tile& update) {
  return dispatch([=]<class Lanes>(std::type_identity<Lanes>) {
    const std::size_t stride = front.stride, columns = panel.end_column - panel.column;
    if (columns > 0) {
      add_children<Lanes>(front, panel);
      const std::size_t rows = panel.end_row - panel.row;
      const bool is_diagonal = panel.row == panel.column;
      double* const own = front.panel + panel.column * stride;
      subtract_all<Lanes>({rows, columns, is_diagonal}, panel.column, front.panel + panel.row,
                          front.panel + panel.column, stride, own + panel.row, stride);
      if (!is_diagonal) {
        divide_columns<Lanes>(columns, rows, own + panel.column, stride, own + panel.row);
      } else if (const std::size_t done = factorize_columns<Lanes>(columns, rows, stride, own + panel.column);
                 done < columns) {
        return panel.column + done;
      }
    }
    if (update.column == update.end_column) return panel.end_column;
    const bool is_diagonal = update.row == update.column;
    const double* const below = front.panel + front.columns;
    for (std::size_t j = update.column; j < update.end_column; j += Triangle::width) {
      const std::size_t from = is_diagonal ? j : update.row;  // rows above the block's diagonal are not stored
      subtract_all<Lanes>({update.end_row - from, std::min(Triangle::width, update.end_column - j), is_diagonal, true},
                          front.columns, below + from, below + j, stride, front.update.column(j) + from,
                          front.update.stride_of(j));
    }
    const std::size_t first = front.columns;
    add_children<Lanes>(front,
                        {first + update.row, first + update.end_row, first + update.column, first + update.end_column});
    return panel.end_column;
  });
}

}  // namespace tanor::detail::kernels
