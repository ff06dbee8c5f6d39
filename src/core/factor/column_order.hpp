#pragma once

#include <cstddef>
#include <vector>

namespace tanor::detail {

/// Returns an order of the columns of a sparse matrix C in which its QR factor has little fill, with each subtree of
/// the column elimination tree together: COLAMD (T. A. Davis, J. R. Gilbert, S. I. Larimore, E. G. Ng, ACM TOMS 30,
/// 2004). The columns of C's row i are columns[row_start[i]] …, increasing. The result is [place in the elimination] ->
/// column. Throws std::bad_alloc.
std::vector<int> order_columns(std::size_t num_columns, const std::vector<int>& row_start,
                               const std::vector<int>& columns);

}  // namespace tanor::detail
