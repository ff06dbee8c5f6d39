#include "statics/exponential_polynomial.hpp"

#include <cmath>

namespace tanor::detail {

namespace {

/// A sum that is so small beside its terms is 0. The velocities of a frame are known to fewer digits than constants.
constexpr double cancelled_terms = 1e-9, cancelled_constants = 1e-13;
/// Frequencies nearer to each other than this part of the fastest one are equal.
constexpr double equal_frequencies = 1e-9;
/// A sum of more terms, beside the constant, is given up.
constexpr std::size_t most_terms_of_a_sum = 1000;

}  // namespace

ExponentialPolynomial ExponentialPolynomial::time() {
  ExponentialPolynomial result;
  result.terms_.push_back({1, 0.0, 1.0, 1.0});
  return result;
}

ExponentialPolynomial ExponentialPolynomial::unknown() {
  ExponentialPolynomial result;
  result.is_known_ = false;
  return result;
}

void ExponentialPolynomial::add(Term term) {
  const double near = equal_frequencies * fastest_;
  is_known_ = is_known_ && std::isfinite(term.size);
  if (term.frequency <= near) term.frequency = 0.0, term.amplitude = term.amplitude.real();
  auto known = std::ranges::find_if(terms_, [&](const Term& each) {
    return each.power == term.power && std::abs(each.frequency - term.frequency) <= near;
  });
  if (known == terms_.end()) known = terms_.insert(known, {term.power, term.frequency, 0.0, 0.0});
  known->amplitude += term.amplitude;
  known->size += term.size;
  const bool is_constant = known == terms_.begin();
  if (std::abs(known->amplitude) <= (is_constant ? cancelled_constants : cancelled_terms) * known->size) {
    if (is_constant)
      known->amplitude = 0.0;
    else
      terms_.erase(known);
  }
  is_known_ = is_known_ && terms_.size() - 1 <= most_terms_of_a_sum;
}

ExponentialPolynomial operator+(const ExponentialPolynomial& a, const ExponentialPolynomial& b) {
  ExponentialPolynomial result = a;
  result.is_known_ = a.is_known_ && b.is_known_;
  result.fastest_ = std::max(a.fastest_, b.fastest_);
  for (const auto& term : b.terms_) result.add(term);
  return result;
}

ExponentialPolynomial operator*(const ExponentialPolynomial& a, const ExponentialPolynomial& b) {
  ExponentialPolynomial result;
  result.is_known_ = a.is_known_ && b.is_known_;
  if (!result.is_known_) return result;
  result.fastest_ = a.fastest_ + b.fastest_;
  for (const auto& one : a.terms_) {
    for (const auto& other : b.terms_) {
      const int power = one.power + other.power;
      const double size = one.size * other.size;
      if (one.frequency == 0.0 || other.frequency == 0.0) {
        result.add({power, one.frequency + other.frequency, one.amplitude * other.amplitude, size});
        continue;
      }
      // Re(x) Re(y) = Re(x y + x conj(y))/2, and Re(z) = Re(conj(z))
      const std::complex<double> apart = one.amplitude * std::conj(other.amplitude);
      result.add({power, one.frequency + other.frequency, 0.5 * one.amplitude * other.amplitude, 0.5 * size});
      result.add({power, std::abs(one.frequency - other.frequency),
                  0.5 * (one.frequency < other.frequency ? std::conj(apart) : apart), 0.5 * size});
    }
  }
  return result;
}

ExponentialPolynomial operator/(const ExponentialPolynomial& a, const ExponentialPolynomial& b) {
  if (!b.is_constant() || b.constant() == 0.0) return ExponentialPolynomial::unknown();
  return a * ExponentialPolynomial(1.0 / b.constant());
}

ExponentialPolynomial sqrt(const ExponentialPolynomial& a) {
  return a.is_constant() && a.constant() > 0.0 ? ExponentialPolynomial(std::sqrt(a.constant())) : a.some_number(0);
}

/// Returns the real part of factor e^(i a) for a linear function a of the time.
ExponentialPolynomial ExponentialPolynomial::turn(std::complex<double> factor) const {
  const std::complex<double> start = factor * std::polar(1.0, constant());
  if (is_constant()) return start.real();
  if (!is_known_ || terms_.size() != 2 || terms_[1].power != 1 || terms_[1].frequency != 0.0) return unknown();
  const double frequency = terms_[1].amplitude.real();
  ExponentialPolynomial result;
  result.fastest_ = std::abs(frequency);
  result.add({0, std::abs(frequency), frequency < 0.0 ? std::conj(start) : start, 1.0});
  return result;
}

/// Returns a number that depends smoothly on the two constants and is not 0.
ExponentialPolynomial ExponentialPolynomial::some_number(int function, const ExponentialPolynomial& b) const {
  if (!is_constant() || !b.is_constant()) return unknown();
  const auto bounded = [](double x) { return x / (1.0 + std::abs(x)); };
  return 1.0 + 0.1 * function + 0.5 * bounded(constant()) + 0.3 * bounded(b.constant());
}

}  // namespace tanor::detail
