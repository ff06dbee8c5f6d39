#include "cholmod_baseline.hpp"

#include <stdexcept>

using namespace tanor;

namespace {

GatherPlan plan_upper(std::span<const Incidence> incidences, const std::vector<double>& weights, std::size_t num_rows) {
  return {list_products(group_by_point(incidences, weights), weights, 0), num_rows, {}, Triangle::Upper};
}

}  // namespace

CholmodBaseline::CholmodBaseline(std::span<const Incidence> incidences, const std::vector<double>& weights,
                                 std::size_t num_rows)
    : plan_(plan_upper(incidences, weights, num_rows)), values_(plan_.rows().size()) {
  cholmod_start(&common_);
  S_.nrow = S_.ncol = num_rows;
  S_.nzmax = values_.size();
  S_.p = const_cast<int*>(plan_.column_start().data());
  S_.i = const_cast<int*>(plan_.rows().data());
  S_.x = values_.data();
  S_.stype = 1;
  S_.itype = CHOLMOD_INT;
  S_.xtype = CHOLMOD_REAL;
  S_.dtype = CHOLMOD_DOUBLE;
  S_.sorted = S_.packed = 1;
  L_ = cholmod_analyze(&S_, &common_);
}

CholmodBaseline::~CholmodBaseline() {
  cholmod_free_factor(&L_, &common_);
  cholmod_finish(&common_);
}

void CholmodBaseline::factorize(const double* blocks) {
  plan_.assemble(blocks, values_.data());
  cholmod_factorize(&S_, L_, &common_);
  if (common_.status != CHOLMOD_OK) throw std::runtime_error("CHOLMOD finds S not positive definite");
}
