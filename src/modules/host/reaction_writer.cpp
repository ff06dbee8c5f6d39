#include "host/reaction_writer.hpp"

namespace tanor::detail {

void ReactionWriter::write(const double* multipliers, double factor, const double* r, const ConstraintForces& wanted) {
  const double* const blocks = linearization_.blocks().data();
  if (!wanted.multipliers.empty()) {
    const Index* const row_of = host_row_.data();
    model_.parallel.for_ranges(host_row_.size(), [&](std::size_t begin, std::size_t end) {
      for (std::size_t a = begin; a < end; ++a) wanted.multipliers[row_of[a]] = factor * multipliers[a];
    });
  }
  if (wanted.forces) {
    model_.gather.reactions(model_.parallel, blocks, multipliers, eta_.data());
    model_.parallel.for_ranges(eta_.size(), [&](std::size_t begin, std::size_t end) {
      for (std::size_t k = begin; k < end; ++k) eta_[k] *= factor;
    });
    transfer_.write(eta_.data(), model_.num_moving(), wanted.forces);
  }
  if (wanted.stress) {
    stress_.resize(9 * model_.num_points());
    sums_.share_virial(multipliers, factor, blocks, r, stress_.data());
    transfer_.scatter_tensors(stress_.data(), model_.num_moving(), wanted.stress);
  }
}

void ReactionWriter::add_to_supports(const ConstraintForces& wanted) const {
  if (wanted.forces) transfer_.add_last(eta_.data(), model_.num_moving(), 3, wanted.forces);
  if (wanted.stress) transfer_.add_last(stress_.data(), model_.num_moving(), 9, wanted.stress);
}

}  // namespace tanor::detail
