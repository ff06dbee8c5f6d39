#include "cli/values.hpp"

#include <algorithm>
#include <utility>

namespace tanor::cli {

Value list(std::vector<std::string>* target) {
  return {Word::Text, [target](const std::string& given) -> std::string {
            for (std::size_t begin = 0; begin <= given.size();) {
              const std::size_t end = std::min(given.find(',', begin), given.size());
              if (end == begin) return "must be names between commas, not '" + given + "'";
              target->push_back(given.substr(begin, end - begin));
              begin = end + 1;
            }
            return {};
          }};
}

Value offer(std::vector<std::string> offers, Value value, Word word) {
  value.word = word;
  value.offers = std::move(offers);
  return value;
}

}  // namespace tanor::cli
