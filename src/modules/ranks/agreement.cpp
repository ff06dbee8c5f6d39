#include "ranks/agreement.hpp"

#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <vector>

namespace tanor::detail {

namespace {

double without_nan(double x) {
  return std::isnan(x) ? std::numeric_limits<double>::infinity() : x;
}

}  // namespace

double Agreement::largest(double own) {
  std::array<double, 1> number{without_nan(own)};
  ranks_.find_largest(number);
  return number[0];
}

double Agreement::sum(double own) {
  std::array<double, 1> number{own};
  ranks_.sum(number);
  return number[0];
}

Outcome Agreement::agree(Outcome own, std::span<double> numbers) {
  return conclude({static_cast<int>(own.status), std::move(own.what)}, numbers);
}

/// Takes one message if nothing failed, since the code goes before the numbers. Of equal codes the first rank's is the
/// largest.
Outcome Agreement::conclude(Report own, std::span<double> numbers) {
  const int size = ranks_.size();
  std::vector<double> all{own.code == 0 ? 0.0 : 1.0 + own.code * size + (size - 1 - ranks_.rank())};
  for (const double number : numbers) all.push_back(without_nan(number));
  ranks_.find_largest(all);
  std::copy(all.begin() + 1, all.end(), numbers.begin());
  if (all[0] == 0.0) return {};
  const int worst = static_cast<int>(all[0]) - 1, code = worst / size, from = size - 1 - worst % size;
  ranks_.share(from, &own.what);
  if (code == input_error) {
    const std::size_t end = own.what.find(separator);
    throw InputError(own.what.substr(0, end), own.what.substr(end + 1));
  }
  if (code == other_error) throw std::runtime_error(own.what);
  return {static_cast<Status>(code), own.what};
}

std::string Agreement::first_text(std::string own) {
  const int size = ranks_.size();
  const auto first = static_cast<int>(largest(own.empty() ? 0.0 : size - ranks_.rank()));
  if (first == 0) return {};
  ranks_.share(size - first, &own);
  return own;
}

}  // namespace tanor::detail
