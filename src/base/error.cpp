#include <tanor/error.hpp>

namespace tanor {

InputError::InputError(std::string where, const std::string& what)
    : std::runtime_error(what), where_(std::move(where)) {}

// Out of line: the class's type information lives in the library, once.
InputError::~InputError() = default;

}  // namespace tanor
