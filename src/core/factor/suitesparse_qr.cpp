#include <SuiteSparseQR.hpp>
#include <algorithm>
#include <new>

#include "base/check.hpp"
#include "factor/sparse_qr.hpp"

/// \file The QR factorization by SuiteSparseQR.
namespace tanor::detail {

namespace {

/// SuiteSparseQR works with long indices only and so needs a cholmod_common of its own.
struct LongCommon {
  cholmod_common c;

  LongCommon() {
    cholmod_l_start(&c);
    c.print = 0;
  }
  ~LongCommon() { cholmod_l_finish(&c); }
  LongCommon(const LongCommon&) = delete;
  LongCommon& operator=(const LongCommon&) = delete;
};

/// The objects that SuiteSparseQR returns; they are freed with this one.
struct Result {
  LongCommon common;
  cholmod_sparse* R = nullptr;
  SuiteSparse_long* order = nullptr;
  SuiteSparse_long num_columns = 0;

  ~Result() {
    cholmod_l_free_sparse(&R, &common.c);
    cholmod_l_free(static_cast<std::size_t>(num_columns), sizeof(SuiteSparse_long), order, &common.c);
  }
};

}  // namespace

TriangularFactor factorize_with_suitesparse(const SparseColumns& C, double tolerance) {
  const std::size_t d = C.num_columns();
  TriangularFactor factor;
  if (C.rows.empty()) {
    for (std::size_t j = 0; j < d; ++j) factor.dependent.push_back(static_cast<int>(j));
    return factor;
  }
  std::vector<SuiteSparse_long> start(C.start.begin(), C.start.end());
  std::vector<SuiteSparse_long> rows(C.rows.begin(), C.rows.end());
  cholmod_sparse view{};
  view.nrow = static_cast<std::size_t>(C.num_rows);
  view.ncol = d;
  view.nzmax = rows.size();
  view.p = start.data();
  view.i = rows.data();
  view.x = const_cast<double*>(C.values.data());
  view.itype = CHOLMOD_LONG;
  view.xtype = CHOLMOD_REAL;
  view.dtype = CHOLMOD_DOUBLE;
  view.packed = 1;

  Result result;
  result.num_columns = static_cast<SuiteSparse_long>(d);
  const SuiteSparse_long rank =
      SuiteSparseQR<double>(SPQR_ORDERING_DEFAULT, tolerance, 0, &view, &result.R, &result.order, &result.common.c);
  const int status = result.common.c.status;
  if (status == CHOLMOD_OUT_OF_MEMORY || status == CHOLMOD_TOO_LARGE) throw std::bad_alloc();
  ensure(rank >= 0 && status >= CHOLMOD_OK, "SuiteSparseQR takes the matrices that we build");

  // Column k of R belongs to column order[k] of C, or to column k without an order. It is independent if it reaches one
  // row further down than those before it.
  const auto* r_start = static_cast<const SuiteSparse_long*>(result.R->p);
  const auto* r_rows = static_cast<const SuiteSparse_long*>(result.R->i);
  const auto* r_values = static_cast<const double*>(result.R->x);
  for (std::size_t k = 0; k < d; ++k) {
    const int column = static_cast<int>(result.order != nullptr ? result.order[k] : static_cast<SuiteSparse_long>(k));
    const SuiteSparse_long *first = r_rows + r_start[k], *last = r_rows + r_start[k + 1];
    const SuiteSparse_long* diagonal = std::find(first, last, static_cast<SuiteSparse_long>(factor.rank()));
    if (diagonal == last) {
      factor.dependent.push_back(column);
      continue;
    }
    const auto append = [&](const SuiteSparse_long* entry) {
      factor.append(static_cast<int>(*entry), r_values[entry - r_rows]);
    };
    for (const SuiteSparse_long* entry = first; entry != last; ++entry)
      if (entry != diagonal) append(entry);
    append(diagonal);
    factor.end_column();
    factor.independent.push_back(column);
  }
  factor.num_rows = static_cast<int>(factor.rank());
  ensure(factor.rank() == static_cast<std::size_t>(rank), "each independent column has a diagonal entry");
  std::sort(factor.dependent.begin(), factor.dependent.end());
  return factor;
}

}  // namespace tanor::detail
