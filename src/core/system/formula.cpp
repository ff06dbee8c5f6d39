#include "system/formula.hpp"

#include <algorithm>
#include <charconv>
#include <numbers>

#include <tanor/error.hpp>

#include "base/suggestion.hpp"
#include "system/even_roots.hpp"

namespace tanor::detail {

namespace {

using Operation = Formula::Operation;

struct Function {
  std::string_view name;
  Operation operation;
  int num_arguments;
  bool takes_more = false;
};

constexpr Function functions[] = {
    {"sqrt", Operation::Sqrt, 1},     {"exp", Operation::Exp, 1},   {"log", Operation::Log, 1},
    {"sin", Operation::Sin, 1},       {"cos", Operation::Cos, 1},   {"tan", Operation::Tan, 1},
    {"asin", Operation::Asin, 1},     {"acos", Operation::Acos, 1}, {"atan", Operation::Atan, 1},
    {"atan2", Operation::Atan2, 2},   {"sinh", Operation::Sinh, 1}, {"cosh", Operation::Cosh, 1},
    {"tanh", Operation::Tanh, 1},     {"abs", Operation::Abs, 1},   {"min", Operation::Min, 2, true},
    {"max", Operation::Max, 2, true},
};

const Function* find_function(std::string_view name) {
  const auto found = std::ranges::find(functions, name, &Function::name);
  return found == std::end(functions) ? nullptr : found;
}

// The functions of <cctype> are not used, since they depend on the locale.
bool is_digit(char c) {
  return '0' <= c && c <= '9';
}
bool is_letter(char c) {
  return ('a' <= c && c <= 'z') || ('A' <= c && c <= 'Z') || c == '_';
}
bool is_space(char c) {
  return c == ' ' || c == '\t' || c == '\n' || c == '\r';
}
bool continues_character(char c) {
  return (c & 0xC0) == 0x80;
}  // second and later bytes of UTF-8

/// Returns the beginning of a text, which ends in "…" if that is not all. It is never cut inside a character.
std::string cut(std::string_view text, std::size_t longest) {
  if (text.size() <= longest) return std::string(text);
  while (longest > 0 && continues_character(text[longest])) --longest;
  return std::string(text.substr(0, longest)) + "…";
}

std::string quote(std::string_view name) {
  return "'" + cut(name, 80) + "'";
}

/// Returns the text on one line, cut if it is long.
std::string make_heading(std::string_view text) {
  std::string line = cut(text, 200);
  std::ranges::replace_if(line, is_space, ' ');
  return "formula \"" + line + "\": ";
}

}  // namespace

/// A recursive descent over the text. There is one function for each rule of the grammar, which emits the code of what
/// it read.
class Formula::Parser {
 public:
  Parser(std::string_view text, std::span<const std::string> variables, const Constants& constants,
         const OwnVariables& own, Formula* formula)
      : text_(text),
        variables_(variables),
        constants_(constants),
        own_(own),
        program_(formula->program_),
        depth_(formula->depth_) {}

  void parse() {
    check_constants();
    parse_sum();
    skip_spaces();
    if (position_ < text_.size()) fail_expecting("an operator or the end");
  }

 private:
  void parse_sum() { parse_joined(&Parser::parse_product, '+', Operation::Add, '-', Operation::Subtract); }
  void parse_product() { parse_joined(&Parser::parse_unary, '*', Operation::Multiply, '/', Operation::Divide); }

  /// Parses operands with one of two operators between them, from left to right.
  void parse_joined(void (Parser::*parse_operand)(), char first, Operation by_first, char second, Operation by_second) {
    (this->*parse_operand)();
    while (true) {
      const bool is_first = accept(first);
      if (!is_first && !accept(second)) return;
      (this->*parse_operand)();
      emit_binary(is_first ? by_first : by_second);
    }
  }

  void parse_unary() {
    // Every recursion comes through here.
    if (++nesting_ > largest_nesting)
      fail(position_, "nested deeper than " + std::to_string(largest_nesting) + " levels");
    if (accept('-')) {
      parse_unary();
      emit_unary({Operation::Negate});
    } else if (accept('+')) {
      parse_unary();
    } else {
      parse_power();
    }
    --nesting_;
  }

  void parse_power() {
    parse_primary();
    if (accept('^')) {
      parse_unary();
      emit_power();
    }
  }

  void parse_primary() {
    skip_spaces();
    const char next = position_ < text_.size() ? text_[position_] : '\0';
    if (is_digit(next) || next == '.') {
      parse_number();
    } else if (is_letter(next)) {
      if (!parse_own_variable()) parse_name();
    } else if (accept('(')) {
      parse_sum();
      expect(')', "an operator or ')'");
    } else {
      fail_expecting("a number, a name or '('");
    }
  }

  void parse_number() {
    double number = 0.0;
    const auto [end, error] = std::from_chars(text_.data() + position_, text_.data() + text_.size(), number);
    const std::size_t length = end - (text_.data() + position_);
    if (error == std::errc::invalid_argument) fail_expecting("a number");
    if (error == std::errc::result_out_of_range) {
      fail(position_, cut(text_.substr(position_, length), 80) + " is outside the range of numbers");
    }
    emit_operand({Operation::Constant, 0, number});
    position_ += length;
  }

  /// Parses a variable that the owner of the formula reads.
  bool parse_own_variable() {
    if (!own_.read) return false;
    try {
      const std::optional<int> variable = own_.read(text_, &position_);
      if (variable) emit_operand({Operation::Variable, *variable});
      return variable.has_value();
    } catch (const TextFault& fault) {
      fail(fault.place, fault.problem);
    }
  }

  void parse_name() {
    const std::size_t start = position_;
    const std::string_view name = word_at(start);
    if (const Function* function = find_function(name)) {
      position_ += name.size();
      parse_arguments(*function);
      return;
    }
    if (const auto variable = std::ranges::find(variables_, name); variable != variables_.end()) {
      emit_operand({Operation::Variable, static_cast<int>(variable - variables_.begin())});
    } else if (const auto constant = constants_.find(name); constant != constants_.end()) {
      emit_operand({Operation::Constant, 0, constant->second});
    } else if (name == "pi") {
      emit_operand({Operation::Constant, 0, std::numbers::pi});
    } else {
      fail(start, quote(name) + " is not known" + suggest_name(name) + "; known names: " + known_names());
    }
    position_ += name.size();
  }

  void parse_arguments(const Function& function) {
    const std::string needs = ": " + std::string(function.name) + " takes " + std::to_string(function.num_arguments) +
                              (function.takes_more           ? " or more arguments"
                               : function.num_arguments == 1 ? " argument"
                                                             : " arguments");
    expect('(', "'('" + needs);
    parse_sum();
    if (function.num_arguments == 1) {
      expect(')', "an operator or ')'" + needs);
      emit_unary({function.operation});
      return;
    }
    expect(',', "an operator or ','" + needs);
    do {
      parse_sum();
      emit_binary(function.operation);
    } while (function.takes_more && accept(','));
    expect(')', function.takes_more ? "an operator, ',' or ')'" : "an operator or ')'" + needs);
  }

  // ---- the program ----

  void emit_operand(const Instruction& instruction) {
    program_.push_back(instruction);
    depth_ = std::max(depth_, ++operands_);
    if (depth_ > largest_depth) {
      fail(position_, "more than " + std::to_string(largest_depth) + " operands wait for their operator here");
    }
  }

  void emit_unary(const Instruction& instruction) {
    if (instruction.operation == Operation::Sqrt && emit_even_root(0.5)) return;
    if (instruction.operation == Operation::Abs && emit_even_root(1.0)) return;
    emit_folded(instruction, 1);
  }

  /// Emits the power of the last operand if that is a product of even powers. It may take two operands more.
  bool emit_even_root(double power) {
    if (operands_ + 2 > largest_depth || !append_even_root(power, &program_)) return false;
    depth_ = std::max(depth_, operands_ + 2);
    return true;
  }

  void emit_binary(Operation operation) {
    emit_folded({operation}, 2);
    --operands_;
  }

  void emit_power() {
    const Instruction exponent = program_.back();
    if (exponent.operation != Operation::Constant) return emit_binary(Operation::Power);
    program_.pop_back();
    --operands_;
    if (detail::is_small_integer(exponent.constant))
      return emit_unary({Operation::IntegerPower, static_cast<int>(exponent.constant)});
    if (emit_even_root(exponent.constant)) return;
    program_.push_back(exponent);
    ++operands_;
    emit_binary(Operation::Power);
  }

  /// Emits an operation. One on constants alone is done here and now.
  void emit_folded(const Instruction& instruction, std::ptrdiff_t num_operands) {
    const auto are_constant = std::all_of(program_.end() - num_operands, program_.end(),
                                          [](const Instruction& i) { return i.operation == Operation::Constant; });
    program_.push_back(instruction);
    if (!are_constant) return;
    const auto first = program_.end() - num_operands - 1;
    const double value = run<2, double>({first, program_.end()}, [](int, double*) {});
    program_.erase(first, program_.end());
    program_.push_back({Operation::Constant, 0, value});
  }

  // ---- the text ----

  void skip_spaces() {
    while (position_ < text_.size() && is_space(text_[position_])) ++position_;
  }

  bool accept(char wanted) {
    skip_spaces();
    if (position_ == text_.size() || text_[position_] != wanted) return false;
    ++position_;
    return true;
  }

  void expect(char wanted, const std::string& expectation) {
    if (!accept(wanted)) fail_expecting(expectation);
  }

  /// Returns the name at a place; empty if there is none.
  std::string_view word_at(std::size_t start) const {
    std::size_t end = start;
    while (end < text_.size() && (is_letter(text_[end]) || (end > start && is_digit(text_[end])))) ++end;
    return text_.substr(start, end - start);
  }

  // ---- messages ----

  void check_constants() const {
    for (const auto& [name, value] : constants_) {
      const std::string_view taken = std::ranges::count(variables_, name) > 0 ? "a variable"
                                     : find_function(name)                    ? "a function"
                                     : name == "pi"                           ? "the number pi"
                                                                              : "";
      if (!taken.empty()) {
        throw InputError("", heading() + "the constant " + quote(name) + " has the name of " + std::string(taken));
      }
      if (!std::isfinite(value)) throw InputError("", heading() + "the constant " + quote(name) + " is not finite");
    }
  }

  std::string suggest_name(std::string_view name) const {
    std::vector<std::string> known(variables_.begin(), variables_.end());
    for (const auto& [constant, value] : constants_) known.push_back(constant);
    for (const Function& function : functions) known.emplace_back(function.name);
    known.insert(known.end(), own_.names.begin(), own_.names.end());
    return std::ranges::count(known, name) > 0 ? "" : suggest(name, known);
  }

  std::string known_names() const {
    std::string names;
    for (const std::string& variable : variables_) names += variable + ", ";
    names += "pi";
    for (const auto& [constant, value] : constants_) names += ", " + constant;
    names += " and the functions ";
    for (const Function& function : functions) {
      names += (&function == functions ? "" : ", ") + std::string(function.name);
    }
    for (const std::string& own : own_.names) names += (&own == own_.names.data() ? ", and of things " : ", ") + own;
    return names;
  }

  /// Throws with what stands at the next place that is no space.
  [[noreturn]] void fail_expecting(const std::string& expectation) {
    skip_spaces();
    const bool is_part = !own_.all.empty() && text_.data() + position_ != own_.all.data() + own_.all.size();
    if (position_ == text_.size())
      fail(position_,
           "found " + (is_part ? quote({text_.data() + position_, 1}) : "the end") + ", expected " + expectation);
    std::string_view found = word_at(position_);
    if (found.empty()) {
      std::size_t end = position_ + 1;
      while (end < text_.size() && continues_character(text_[end])) ++end;
      found = text_.substr(position_, end - position_);
    }
    fail(position_, "found " + quote(found) + ", expected " + expectation);
  }

  [[noreturn]] void fail(std::size_t place, const std::string& problem) const {
    refuse(text_, {place, problem}, own_.all);
  }

  std::string heading() const { return make_heading(own_.all.empty() ? text_ : own_.all); }

  static constexpr int largest_nesting = 200;

  std::string_view text_;
  std::span<const std::string> variables_;
  const Constants& constants_;
  const OwnVariables& own_;
  std::vector<Instruction>& program_;
  int& depth_;
  std::size_t position_ = 0;
  int operands_ = 0;  ///< number on the stack after the program so far
  int nesting_ = 0;
};

Formula::Formula(std::string_view text, std::span<const std::string> variables, const Constants& constants)
    : Formula(text, variables, constants, {}) {}

Formula::Formula(std::string_view text, std::span<const std::string> variables, const Constants& constants,
                 const OwnVariables& own) {
  Parser(text, variables, constants, own, this).parse();
  program_.shrink_to_fit();
}

void Formula::refuse(std::string_view text, const TextFault& fault, std::string_view all) {
  const std::size_t first = all.empty() ? 0 : static_cast<std::size_t>(text.data() - all.data());
  if (!all.empty()) text = all;
  const auto before = text.substr(0, first + fault.place);
  const auto column = 1 + before.size() - std::ranges::count_if(before, continues_character);
  throw InputError("", make_heading(text) + "column " + std::to_string(column) + ": " + fault.problem);
}

}  // namespace tanor::detail
