#include <tanor/error.hpp>

namespace tanor {
using namespace detail;

InputError::InputError(std::string where, const std::string& what)
    : std::runtime_error(what), where_(std::move(where)) {}

// The destructor is defined out of line, so that the type information of the class stands in the library once.
InputError::~InputError() = default;

}  // namespace tanor
