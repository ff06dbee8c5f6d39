#include "cli/values.hpp"

#include <algorithm>

namespace tanor::cli {

Value list(Word word, std::vector<std::string>* target) {
  return {word, [target](const std::string& given) -> std::string {
            for (std::size_t begin = 0; begin <= given.size();) {
              const std::size_t end = std::min(given.find(',', begin), given.size());
              if (end == begin) return "must be names between commas, not '" + given + "'";
              target->push_back(given.substr(begin, end - begin));
              begin = end + 1;
            }
            return {};
          }};
}

}  // namespace tanor::cli
