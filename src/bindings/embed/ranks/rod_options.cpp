#include "embed/ranks/rod_options.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <stdexcept>
#include <string>
#include <string_view>

namespace tanor::embed {
namespace {

template <class Number>
bool read(std::string_view word, Number* number) {
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), *number);
  return error == std::errc() && end == word.data() + word.size();
}

[[noreturn]] void refuse(const std::string& what) {
  throw std::invalid_argument(
      what + "; known is: bond TYPE ... [length initial|VALUE] [tolerance VALUE] [store no|yes|STEPS]");
}

double read_positive(std::string_view keyword, std::string_view word) {
  double value = 0.0;
  if (!read(word, &value) || !(value > 0.0) || !std::isfinite(value))
    refuse(std::string(keyword) + " " + std::string(word) + " is no positive number");
  return value;
}

int read_steps(std::string_view word) {
  int steps = 0;
  if (word == "no") return 0;
  if (word == "yes") return 1;
  if (!read(word, &steps) || steps < 1) refuse("store " + std::string(word) + " is no number of steps");
  return steps;
}

}  // namespace

RodOptions read_rod_options(std::span<char* const> words, int num_bond_types) {
  RodOptions options;
  std::size_t k = 0;
  const auto next = [&](std::string_view keyword) -> std::string_view {
    if (k == words.size()) refuse(std::string(keyword) + " lacks its value");
    return words[k++];
  };
  while (k < words.size()) {
    const std::string_view keyword = words[k++];
    if (keyword == "bond") {
      for (int type = 0; k < words.size() && read(std::string_view(words[k]), &type); ++k) {
        if (type < 1 || type > num_bond_types)
          throw std::invalid_argument("there is no bond type " + std::to_string(type) + "; there are " +
                                      std::to_string(num_bond_types));
        if (std::find(options.types.begin(), options.types.end(), type) == options.types.end())
          options.types.push_back(type);
      }
    } else if (keyword == "length") {
      const std::string_view word = next(keyword);
      options.length = word == "initial" ? 0.0 : read_positive(keyword, word);
    } else if (keyword == "tolerance") {
      options.tolerance = read_positive(keyword, next(keyword));
    } else if (keyword == "store") {
      options.store_every = read_steps(next(keyword));
    } else {
      refuse("unknown word " + std::string(keyword));
    }
  }
  if (options.types.empty()) refuse("no bond types are given");
  return options;
}

}  // namespace tanor::embed
