#include "statics/tall_products.hpp"

#include <algorithm>
#include <cstddef>
#include <type_traits>

#include "base/instruction_sets.hpp"
#include "base/pack.hpp"

namespace tanor::detail {

using Eigen::MatrixXd;

namespace {

constexpr std::size_t tile = 4;      // columns of each factor that are processed at once
constexpr std::size_t height = 512;  // rows of all columns that fit the second-level cache

/// A matrix by columns, `stride` numbers apart.
template <class Number>
struct Columns {
  Number* numbers;
  std::size_t columns, stride;
  Number* at(std::size_t i, std::size_t j) const { return numbers + j * stride + i; }
};

/// Calls body<width>(j) for all columns, `tile` at once and then one by one.
template <class Body>
[[gnu::always_inline]] inline void for_tiles(std::size_t columns, const Body& body) {
  std::size_t j = 0;
  for (; j + tile <= columns; j += tile) body(std::integral_constant<std::size_t, tile>{}, j);
  for (; j < columns; ++j) body(std::integral_constant<std::size_t, 1>{}, j);
}

/// Computes c_pq += sum over `rows` of a_ip b_iq.
template <class Lanes, std::size_t wide, std::size_t broad>
[[gnu::always_inline]] inline void add_dots(std::size_t rows, const Columns<const double>& a,
                                            const Columns<const double>& b, std::size_t i, const Columns<double>& c,
                                            std::size_t p, std::size_t q) {
  Lanes sum[wide][broad]{};
  const std::size_t end = i + rows;
  for (; i + num_lanes <= end; i += num_lanes) {
    Lanes b_i[broad];
    for (std::size_t y = 0; y < broad; ++y) b_i[y] = Lanes::at(b.at(i, q + y));
    for (std::size_t x = 0; x < wide; ++x) {
      const Lanes a_i = Lanes::at(a.at(i, p + x));
      for (std::size_t y = 0; y < broad; ++y) sum[x][y] += a_i * b_i[y];
    }
  }
  for (std::size_t x = 0; x < wide; ++x) {
    for (std::size_t y = 0; y < broad; ++y) {
      double rest = sum[x][y].sum();
      for (std::size_t k = i; k < end; ++k) rest += *a.at(k, p + x) * *b.at(k, q + y);
      *c.at(p + x, q + y) += rest;
    }
  }
}

/// Computes b_iq -= sum over k of a_ik c_kq, in `lanes` x 8 rows from the i-th on.
template <class Lanes, std::size_t lanes, std::size_t broad>
[[gnu::always_inline]] inline void subtract_rows(const Columns<const double>& a, const Columns<const double>& c,
                                                 const Columns<double>& b, std::size_t i, std::size_t q) {
  Lanes sum[broad][lanes];
  for (std::size_t y = 0; y < broad; ++y) {
    for (std::size_t x = 0; x < lanes; ++x) sum[y][x] = Lanes::at(b.at(i + num_lanes * x, q + y));
  }
  for (std::size_t k = 0; k < a.columns; ++k) {
    Lanes a_k[lanes];
    for (std::size_t x = 0; x < lanes; ++x) a_k[x] = Lanes::at(a.at(i + num_lanes * x, k));
    for (std::size_t y = 0; y < broad; ++y) {
      for (std::size_t x = 0; x < lanes; ++x) sum[y][x] -= *c.at(k, q + y) * a_k[x];
    }
  }
  for (std::size_t y = 0; y < broad; ++y) {
    for (std::size_t x = 0; x < lanes; ++x) sum[y][x].write(b.at(i + num_lanes * x, q + y));
  }
}

void add_transposed_product(std::size_t rows, const Columns<const double>& a, const Columns<const double>& b,
                            const Columns<double>& c) {
  dispatch([=, &a, &b, &c]<class Lanes>(std::type_identity<Lanes>) {
    for (std::size_t i = 0; i < rows; i += height) {
      const std::size_t some = std::min(height, rows - i);
      for_tiles(
          a.columns, [&](auto wide, std::size_t p) __attribute__((always_inline)) {
            for_tiles(
                b.columns, [&](auto broad, std::size_t q) __attribute__((always_inline)) {
                  add_dots<Lanes, wide, broad>(some, a, b, i, c, p, q);
                });
          });
    }
  });
}

void subtract_tall_product(std::size_t rows, const Columns<const double>& a, const Columns<const double>& c,
                           const Columns<double>& b) {
  dispatch([=, &a, &c, &b]<class Lanes>(std::type_identity<Lanes>) {
    for (std::size_t first = 0; first < rows; first += height) {
      const std::size_t end = std::min(rows, first + height);
      for_tiles(
          b.columns, [&](auto broad, std::size_t q) __attribute__((always_inline)) {
            std::size_t i = first;
            for (; i + 2 * num_lanes <= end; i += 2 * num_lanes) subtract_rows<Lanes, 2, broad>(a, c, b, i, q);
            for (; i + num_lanes <= end; i += num_lanes) subtract_rows<Lanes, 1, broad>(a, c, b, i, q);
            for (; i < end; ++i) {
              for (std::size_t y = 0; y < broad; ++y) {
                for (std::size_t k = 0; k < a.columns; ++k) *b.at(i, q + y) -= *a.at(i, k) * *c.at(k, q + y);
              }
            }
          });
    }
  });
}

Columns<const double> columns_of(const TallMatrix& A) {
  return {A.data(), static_cast<std::size_t>(A.cols()), static_cast<std::size_t>(A.outerStride())};
}
Columns<double> columns_of(MatrixXd* A) {
  return {A->data(), static_cast<std::size_t>(A->cols()), static_cast<std::size_t>(A->rows())};
}

}  // namespace

MatrixXd multiply_transposed(const TallMatrix& A, const TallMatrix& B) {
  MatrixXd result = MatrixXd::Zero(A.cols(), B.cols());
  add_transposed_product(static_cast<std::size_t>(A.rows()), columns_of(A), columns_of(B), columns_of(&result));
  return result;
}

MatrixXd multiply_tall(const TallMatrix& A, const MatrixXd& C) {
  MatrixXd result = MatrixXd::Zero(A.rows(), C.cols());
  subtract_product(A, -C, &result);
  return result;
}

void subtract_product(const TallMatrix& A, const MatrixXd& C, MatrixXd* B) {
  subtract_tall_product(static_cast<std::size_t>(A.rows()), columns_of(A), columns_of(C), columns_of(B));
}

}  // namespace tanor::detail
