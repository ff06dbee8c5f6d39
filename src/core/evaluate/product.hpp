#pragma once

namespace tanor::detail {

/// One product of X'WX (S, Gamma, H, G). It adds weight * g_a.g_b of the blocks a, b to the entry (row, column). The
/// weight is sign_a sign_b w of the point that both rows share, or the sum over several points if the blocks are the
/// same.
struct Product {
  int row, column;  // row >= column
  int block_a, block_b;
  double weight;
};

}  // namespace tanor::detail
