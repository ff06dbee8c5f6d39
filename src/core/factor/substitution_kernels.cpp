#include <algorithm>
#include <utility>

#include "base/instruction_sets.hpp"
#include "factor/front_lanes.hpp"

/// \file Products with the columns of a front, and both substitutions.
namespace tanor::detail::kernels {

namespace {

constexpr std::size_t line = 8;  // numbers of a cache line

/// Prefetches what a pass over columns reads next. Panels are too small, and follow each other too quickly, for the
/// hardware prefetcher: with this call, a solve of a net takes 0.6 times as long.
[[gnu::always_inline]] inline void fetch(const double* from, std::size_t count) {
  for (std::size_t k = 0; k < count; k += line) __builtin_prefetch(from + k, 0, 2);
}

/// Does the same from the last line to the first, for a pass that goes down through L. In the other order the hardware
/// prefetcher runs against it: panels beyond the caches then came at 29 in place of 40 GB/s.
[[gnu::always_inline]] inline void fetch_downwards(const double* from, std::size_t count) {
  for (std::size_t k = count; k > 0; k -= line) __builtin_prefetch(from + k - line, 0, 2);
}

/// Computes y -= C x for neighbouring columns and the rows [first, end) in whole lanes.
template <class Lanes, std::size_t columns>
[[gnu::always_inline]] inline void subtract_columns(const double* c, std::size_t stride, std::size_t first,
                                                    std::size_t end, const double* x, double* y) {
  for (std::size_t i = first; i < end; i += front_width) {
    Lanes sum = Lanes::at(y + i);
    for (std::size_t q = 0; q < columns; ++q) sum -= x[q] * Lanes::at(c + q * stride + i);
    sum.write(y + i);
  }
}

/// Computes sums = C'y for the same columns and rows.
template <class Lanes, std::size_t columns>
[[gnu::always_inline]] inline void multiply_columns(const double* c, std::size_t stride, std::size_t first,
                                                    std::size_t end, const double* y, double* sums) {
  Lanes sum[columns]{};
  for (std::size_t i = first; i < end; i += front_width) {
    const Lanes y_i = Lanes::at(y + i);
    for (std::size_t q = 0; q < columns; ++q) sum[q] += Lanes::at(c + q * stride + i) * y_i;
  }
  for (std::size_t q = 0; q < columns; ++q) sums[q] = sum[q].sum();
}

/// Writes x to the first lanes at y, as a whole: a load that follows soon would wait for single numbers.
template <class Lanes, std::size_t columns>
[[gnu::always_inline]] inline void write_lanes(const double (&x)[columns], double* y) {
  const Lanes all = Lanes::of([&](auto lane) __attribute__((always_inline)) {
    if constexpr (lane < columns)
      return x[lane];
    else
      return y[lane];
  });
  all.write(y);
}

/// Calls work(j, count) for columns [j, j + count) of a panel, a few at a time, and prefetches those after the next.
template <class Work>
[[gnu::always_inline]] inline void for_columns_of(const Panel& panel, const Work& work) {
  for (std::size_t j = 0; j < panel.columns; j += tile) {
    with_columns(
        panel.columns - j, [&](auto count) __attribute__((always_inline)) {
          for (std::size_t q = 0; q < count; ++q) fetch(panel.numbers + (j + 2 * tile + q) * panel.stride, panel.rows);
          work(j, count);
        });
  }
}
}  // namespace

void subtract_product(const Panel& panel, const double* x, double* y) {
  dispatch([=]<class Lanes>(std::type_identity<Lanes>) {
    for_columns_of(
        panel, [=](std::size_t j, auto count) __attribute__((always_inline)) {
          subtract_columns<Lanes, count>(panel.numbers + j * panel.stride, panel.stride, 0, panel.rows, x + j, y);
        });
  });
}

void find_products(const Panel& panel, const double* y, double* sums) {
  dispatch([=]<class Lanes>(std::type_identity<Lanes>) {
    for_columns_of(
        panel, [=](std::size_t j, auto count) __attribute__((always_inline)) {
          multiply_columns<Lanes, count>(panel.numbers + j * panel.stride, panel.stride, 0, panel.rows, y, sums + j);
        });
  });
}

void substitute_forwards(const Panel& panel, std::size_t ahead, double* y) {
  dispatch([=]<class Lanes>(std::type_identity<Lanes>) {
    const auto [columns, rows, stride, numbers, inverse_pivots] = panel;
    for (std::size_t j = 0; j < columns; j += front_width) {
      with_columns<front_width>(
          columns - j, [&](auto count) __attribute__((always_inline)) {
            const double* const c = numbers + j * stride;
            if (ahead > 0) fetch(c + ahead, count * stride);
            // x_q = (y_q - sum over k < q of c_qk x_k)/pivot, with one operation a row from x_k to x_q
            double x[count];
            for_constants<count>([&](auto q) __attribute__((always_inline)) {
              const double inverse = inverse_pivots[j + q];
              x[q] = y[j + q] * inverse;
              for_constants<q>([&](auto k)
                                   __attribute__((always_inline)) { x[q] -= c[k * stride + j + q] * inverse * x[k]; });
            });
            if constexpr (count < front_width) subtract_columns<Lanes, count>(c, stride, j, j + front_width, x, y);
            write_lanes<Lanes, count>(x, y + j);
            subtract_columns<Lanes, count>(c, stride, j + front_width, rows, x, y);
          });
    }
  });
}

void substitute_backwards(const Panel& panel, std::size_t ahead, double* y) {
  dispatch([=]<class Lanes>(std::type_identity<Lanes>) {
    const auto [columns, rows, stride, numbers, inverse_pivots] = panel;
    for (std::size_t end = columns, j = lanes_of(columns - 1);; end = j, j -= front_width) {
      with_columns<front_width>(
          end - j, [&](auto count) __attribute__((always_inline)) {
            const double* const c = numbers + j * stride;
            if (ahead > 0) fetch_downwards(c - ahead, count * stride);
            double x[count];
            for (std::size_t q = 0; q < count; ++q) x[q] = y[j + q];
            if constexpr (count < front_width) {
              constexpr double zeros[count]{};
              write_lanes<Lanes, count>(zeros, y + j);
            }
            double sums[front_width];
            const std::size_t first = count < front_width ? j : j + front_width;
            multiply_columns<Lanes, std::min<std::size_t>(count, tile)>(c, stride, first, rows, y, sums);
            if constexpr (count > tile)
              multiply_columns<Lanes, count - tile>(c + tile * stride, stride, first, rows, y, sums + tile);
            for_constants<count>([&](auto above) __attribute__((always_inline)) {
              constexpr std::size_t q = count - 1 - above;
              const double inverse = inverse_pivots[j + q];
              x[q] = (x[q] - sums[q]) * inverse;
              for_constants<above>([&](auto before) __attribute__((always_inline)) {
                constexpr std::size_t k = count - 1 - before;
                x[q] -= c[q * stride + j + k] * inverse * x[k];
              });
            });
            write_lanes<Lanes, count>(x, y + j);
          });
      if (j == 0) return;
    }
  });
}

void substitute_pack_forwards(const Panel& panel, const int* places, double* x) {
  dispatch([=]<class Lanes>(std::type_identity<Lanes>) {
    const auto [columns, rows, stride, numbers, inverse_pivots] = panel;
    const auto row = [&](std::size_t i) __attribute__((always_inline)) {
      return x + front_width * static_cast<std::size_t>(places[i]);
    };
    for (std::size_t j = 0; j < columns; j += tile) {
      with_columns(
          columns - j, [&](auto count) __attribute__((always_inline)) {
            const double* const c = numbers + j * stride;
            Lanes own[count];
            for (std::size_t q = 0; q < count; ++q) {
              own[q] = Lanes::at(row(j + q));
              for (std::size_t k = 0; k < q; ++k) own[q] -= c[k * stride + j + q] * own[k];
              own[q] = inverse_pivots[j + q] * own[q];
              own[q].write(row(j + q));
            }
            for (std::size_t i = j + count; i < rows; ++i) {
              Lanes sum = Lanes::at(row(i));
              for (std::size_t q = 0; q < count; ++q) sum -= c[q * stride + i] * own[q];
              sum.write(row(i));
            }
          });
    }
  });
}

void substitute_pack_backwards(const Panel& panel, const int* places, double* x) {
  dispatch([=]<class Lanes>(std::type_identity<Lanes>) {
    const auto [columns, rows, stride, numbers, inverse_pivots] = panel;
    const auto row = [&](std::size_t i) __attribute__((always_inline)) {
      return x + front_width * static_cast<std::size_t>(places[i]);
    };
    for (std::size_t end = columns, j = (columns - 1) / tile * tile;; end = j, j -= tile) {
      with_columns(
          end - j, [&](auto count) __attribute__((always_inline)) {
            const double* const c = numbers + j * stride;
            Lanes own[count];
            for (std::size_t q = 0; q < count; ++q) own[q] = Lanes::at(row(j + q));
            for (std::size_t i = j + count; i < rows; ++i) {
              const Lanes x_i = Lanes::at(row(i));
              for (std::size_t q = 0; q < count; ++q) own[q] -= c[q * stride + i] * x_i;
            }
            for (std::size_t q = count; q-- > 0;) {
              for (std::size_t k = q + 1; k < count; ++k) own[q] -= c[q * stride + j + k] * own[k];
              own[q] = inverse_pivots[j + q] * own[q];
              own[q].write(row(j + q));
            }
          });
      if (j == 0) return;
    }
  });
}

}  // namespace tanor::detail::kernels
