#include "dynamics/decisions.hpp"

#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

#include <tanor/error.hpp>

namespace tanor::detail {

namespace {

constexpr int input_error = 100, other_error = 101;  // codes beyond those of a Status
constexpr char separator = '\x1f';

double without_nan(double x) {
  return std::isnan(x) ? std::numeric_limits<double>::infinity() : x;
}

}  // namespace

void Decisions::take_largest(std::span<double> numbers) {
  if (is_alone()) return;
  std::ranges::transform(numbers, numbers.begin(), without_nan);
  ranks_->find_largest(numbers);
}

Power Decisions::sum(const Power& own) {
  std::array<double, 5> all{own.supports, own.forces, own.potentials, own.friction, own.impacts};
  add(all);
  return {.supports = all[0], .forces = all[1], .potentials = all[2], .friction = all[3], .impacts = all[4]};
}

Share Decisions::share(std::size_t own) {
  if (is_alone()) return {{0, own}, 0};
  const auto here = static_cast<std::size_t>(ranks_->rank());
  std::vector<double> counts(static_cast<std::size_t>(ranks_->size()), 0.0);
  counts[here] = static_cast<double>(own);
  ranks_->sum(counts);
  Share share;
  for (const double count : counts) share.start.push_back(share.all() + static_cast<std::size_t>(count));
  share.first = share.start[here];
  return share;
}

std::string Decisions::first_text(std::string own) {
  if (is_alone()) return own;
  const int size = ranks_->size();
  const auto first = static_cast<int>(largest(own.empty() ? 0.0 : size - ranks_->rank()));
  if (first == 0) return {};
  ranks_->share(size - first, &own);
  return own;
}

Outcome Decisions::agree(const std::function<Outcome()>& work, std::span<double> numbers) {
  Report report;
  is_apart_ = true;
  try {
    Outcome found = work();
    report = {static_cast<int>(found.status), std::move(found.what)};
  } catch (const InputError& error) {
    report = {input_error, error.where() + separator + error.what()};
  } catch (const std::exception& error) {
    report = {other_error, error.what()};
  }
  is_apart_ = false;
  return conclude(std::move(report), numbers);
}

/// Takes one message if nothing failed, since the code goes before the numbers. Of equal codes the first process's is
/// the largest.
Outcome Decisions::conclude(Report own, std::span<double> numbers) {
  const int size = ranks_->size();
  std::vector<double> all{own.code == 0 ? 0.0 : 1.0 + own.code * size + (size - 1 - ranks_->rank())};
  all.insert(all.end(), numbers.begin(), numbers.end());
  take_largest(all);
  std::copy(all.begin() + 1, all.end(), numbers.begin());
  if (all[0] == 0.0) return {};
  const int worst = static_cast<int>(all[0]) - 1, code = worst / size, from = size - 1 - worst % size;
  ranks_->share(from, &own.what);
  if (code == input_error) {
    const std::size_t end = own.what.find(separator);
    throw InputError(own.what.substr(0, end), own.what.substr(end + 1));
  }
  if (code == other_error) throw std::runtime_error(own.what);
  return {static_cast<Status>(code), own.what};
}

}  // namespace tanor::detail
