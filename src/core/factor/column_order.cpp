#include "factor/column_order.hpp"

#include <cholmod.h>

#include <new>
#include <numeric>

#include "base/check.hpp"

namespace tanor::detail {

std::vector<int> order_columns(std::size_t num_columns, const std::vector<int>& row_start,
                               const std::vector<int>& columns) {
  std::vector<int> order(num_columns);
  std::iota(order.begin(), order.end(), 0);
  if (columns.empty()) return order;
  cholmod_sparse transposed{};
  transposed.nrow = num_columns;
  transposed.ncol = row_start.size() - 1;
  transposed.nzmax = columns.size();
  transposed.p = const_cast<int*>(row_start.data());
  transposed.i = const_cast<int*>(columns.data());
  transposed.itype = CHOLMOD_INT;
  transposed.xtype = CHOLMOD_PATTERN;
  transposed.sorted = transposed.packed = 1;
  cholmod_common common;
  cholmod_start(&common);
  common.print = 0;
  cholmod_colamd(&transposed, nullptr, 0, /*postorder=*/1, order.data(), &common);
  const int status = common.status;
  cholmod_finish(&common);
  if (status == CHOLMOD_OUT_OF_MEMORY || status == CHOLMOD_TOO_LARGE) throw std::bad_alloc();
  ensure(status >= CHOLMOD_OK, "COLAMD takes the matrices that we build");
  return order;
}

}  // namespace tanor::detail
