#include "scene/document.hpp"

#include <algorithm>
#include <cctype>
#include <limits>
#include <set>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <tanor/error.hpp>

namespace tanor::scene {
namespace {

/// Largest depth of lists and objects; docs/scene-format.md needs seven.
constexpr std::size_t largest_depth = 100;

constexpr Document::Node open_end = std::numeric_limits<Document::Node>::max();

/// Escapes control characters as JSON does, so that a message stays on one line.
std::string escape(std::string_view text) {
  std::string escaped;
  for (const char c : text) {
    if (static_cast<unsigned char>(c) < 0x20)
      escaped += fmt::format("\\u{:04x}", c);
    else
      escaped += c;
  }
  return escaped;
}

/// Returns the word of the text that stands at a position, to its end.
std::string_view word_at(std::string_view text, std::size_t position) {
  constexpr std::string_view delimiters = " \t\r\n,:[]{}\"";
  const std::size_t before = text.substr(0, position).find_last_of(delimiters);
  text.remove_prefix(before == std::string_view::npos ? 0 : before + 1);
  return text.substr(0, text.find_first_of(delimiters));
}

/// Returns true if the word means NaN or infinity, which JSON does not have.
bool spells_not_finite(std::string_view word) {
  if (word.starts_with('-') || word.starts_with('+')) word.remove_prefix(1);
  std::string small(word);
  for (char& c : small) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return small == "nan" || small == "inf" || small == "infinity";
}

/// Extracts from nlohmann's message what the parser expected.
std::string_view expected(std::string_view message) {
  const std::size_t found = message.rfind("; expected ");
  return found == std::string_view::npos ? "" : message.substr(found);
}

}  // namespace

/// Writes the tape from nlohmann's events.
class Document::Builder {
 public:
  Builder(std::string_view text, Document* document) : text_(text), document_(*document) {}

  // The names of these functions are nlohmann's.
  bool null() { return add(Type::Null, 0.0); }
  bool boolean(bool value) { return add(Type::Boolean, value ? 1.0 : 0.0); }
  bool number_integer(std::int64_t value) { return add(Type::Number, static_cast<double>(value)); }
  bool number_unsigned(std::uint64_t value) { return add(Type::Number, static_cast<double>(value)); }
  bool number_float(double value, const std::string&) { return add(Type::Number, value); }
  bool string(std::string& value) { return add_string(std::move(value)); }
  bool binary(std::vector<std::uint8_t>&) { return false; }

  bool start_array(std::size_t) { return open(Type::List); }
  bool end_array() { return close(); }
  bool start_object(std::size_t) { return open(Type::Object); }
  bool end_object() { return close(); }
  bool key(std::string& key) {
    if (!containers_.back().keys.insert(key).second) {
      const std::string pointer = document_.pointer(containers_.back().node) + pointer_step(key);
      throw InputError(document_.where(pointer), fmt::format("found the key {} twice, wanted once", quote(key)));
    }
    return add_string(std::move(key));
  }

  bool parse_error(std::size_t position, const std::string&, const nlohmann::detail::exception& error) {
    constexpr int number_overflow = 406;
    // "[json.exception…] parse error at line 1, column 2: syntax error while parsing … - …; last read: '…'"
    std::string_view message = error.what();
    // After the end of the document there is no place that a pointer could name.
    const bool is_inside = !containers_.empty() || document_.tape_.empty();
    const bool is_value =
        is_inside && message.substr(0, message.find(" - ")).find("while parsing value") != std::string_view::npos;
    const std::string_view word = word_at(text_, position);
    if (error.id == number_overflow || (is_value && spells_not_finite(word)))
      throw InputError(document_.where(document_.pointer(static_cast<Node>(document_.tape_.size()))),
                       fmt::format("found {}, wanted a finite number", cut(word, 80)));

    const std::string_view before = text_.substr(0, position);
    const auto line = 1 + std::count(before.begin(), before.end(), '\n');
    const std::size_t column = std::max<std::size_t>(1, before.size() - (before.rfind('\n') + 1));
    message.remove_prefix(std::min(message.find("syntax error"), message.size()));
    const std::size_t last_read = message.find("; last read");  // it contains more than the word in question
    const bool has_word = message.find("invalid literal") < last_read || message.find("invalid number") < last_read;
    throw InputError(
        fmt::format("{}: line {}, column {}", document_.file_, line, column),
        fmt::format("not JSON: {}{}{}", has_word ? "found " + quote(word) + ", " : "", message.substr(0, last_read),
                    expected(message.substr(std::min(last_read, message.size())))));
  }

 private:
  struct Container {
    Node node;
    std::set<std::string> keys;
  };

  bool add(Type type, double number) {
    const std::size_t end = document_.tape_.size() + 1;
    if (end >= open_end) throw InputError(document_.file_, "more values than a scene may have, 4e9");
    document_.tape_.push_back({.type = type, .end = static_cast<Node>(end), .number = number});
    return true;
  }
  bool add_string(std::string&& text) {
    add(Type::String, 0.0);
    document_.tape_.back().string = document_.strings_.size();
    document_.strings_.push_back(std::move(text));
    return true;
  }
  bool open(Type type) {
    const auto node = static_cast<Node>(document_.tape_.size());
    if (containers_.size() == largest_depth)
      throw InputError(
          document_.file_,
          fmt::format("found more than {} lists and objects inside one another, wanted a scene", largest_depth));
    containers_.push_back({node, {}});
    add(type, 0.0);
    document_.tape_.back().end = open_end;
    return true;
  }
  bool close() {
    document_.tape_[containers_.back().node].end = static_cast<Node>(document_.tape_.size());
    containers_.pop_back();
    return true;
  }

  std::string_view text_;
  Document& document_;
  std::vector<Container> containers_;
};

Document::Document(const std::string& text, std::string file) : file_(std::move(file)) {
  Builder builder(text, this);
  nlohmann::json::sax_parse(text, &builder);
}

std::string Document::pointer(Node node) const {
  std::string path;
  for (Node holder = 0; holder != node;) {
    const bool has_keys = type(holder) == Type::Object;
    std::size_t index = 0;
    Node child = holder + 1 + has_keys;
    for (; child < tape_.size() && end(child) <= node; ++index) child = end(child) + has_keys;
    path += has_keys ? pointer_step(string(child - 1)) : pointer_step(std::to_string(index));
    holder = child;
  }
  return path;
}

std::string Document::where(std::string_view pointer) const {
  return pointer.empty() ? file_ : fmt::format("{}: {}", file_, pointer);
}

std::string pointer_step(std::string_view key) {
  std::string step = "/";
  for (const char c : key) {
    if (c == '~')
      step += "~0";
    else if (c == '/')
      step += "~1";
    else
      step += c;
  }
  return escape(step);
}

std::string cut(std::string_view text, std::size_t longest) {
  if (text.size() <= longest) return std::string(text);
  while (longest > 0 && (text[longest] & 0xC0) == 0x80) --longest;
  return std::string(text.substr(0, longest)) + "…";
}

std::string quote(std::string_view text) {
  return "\"" + cut(escape(text), 80) + "\"";
}

}  // namespace tanor::scene
