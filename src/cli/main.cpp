#include <variant>

#include "cli/command_line.hpp"
#include "cli/machine.hpp"
#include "cli/messages.hpp"

/// The `tanor` program: scene files in, reports out.
int main(int argc, char** argv) {
  using namespace tanor::cli;
  try {
    keep_blas_serial();
    const Command command = parse_command_line(argc, argv);
    return static_cast<int>(std::visit([](const auto& options) { return execute(options); }, command));
  } catch (...) {
    const Failure failure = describe_current_exception();
    print_message(failure.message);
    return static_cast<int>(failure.code);
  }
}
