// A small preprocessor: comments, #if with integer expressions, object-like #define.
#include "backends/gl/names_used.h"

#include <cctype>
#include <cstdlib>
#include <optional>
#include <sstream>
#include <vector>

namespace pliant::gl {

namespace {

using Macros = std::map<std::string, std::string>;
using Value = std::optional<long>; // nothing: cannot be decided

bool begins_name(char c) {
  return std::isalpha(static_cast<unsigned char>(c)) || c == '_';
}
bool in_name(char c) {
  return std::isalnum(static_cast<unsigned char>(c)) || c == '_';
}

// Comments become spaces and continued lines one line.
std::string without_comments(const std::string& text) {
  std::string result;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text.compare(i, 2, "//") == 0) {
      while (i < text.size() && text[i] != '\n') ++i;
      result += '\n';
    } else if (text.compare(i, 2, "/*") == 0) {
      const std::size_t end = text.find("*/", i + 2);
      i = end == std::string::npos ? text.size() : end + 1;
      result += ' ';
    } else if (text.compare(i, 2, "\\\n") == 0) {
      ++i;
      result += ' ';
    } else {
      result += text[i];
    }
  }
  return result;
}

// Names, numbers and operators of one line.
std::vector<std::string> tokens_of(const std::string& line) {
  std::vector<std::string> tokens;
  for (std::size_t i = 0; i < line.size();) {
    std::size_t end = i + 1;
    if (in_name(line[i])) {
      while (end < line.size() && in_name(line[end])) ++end;
    } else if (std::isspace(static_cast<unsigned char>(line[i]))) {
      i = end;
      continue;
    } else {
      for (const char* wide : {"==", "!=", "<=", ">=", "&&", "||"})
        if (line.compare(i, 2, wide) == 0) end = i + 2;
    }
    tokens.push_back(line.substr(i, end - i));
    i = end;
  }
  return tokens;
}

// Integer expressions of #if, by descent through the levels of precedence.
class Expression {
public:
  Expression(std::vector<std::string> tokens, const Macros& macros, int depth = 0)
      : tokens_(std::move(tokens)), macros_(macros), depth_(depth) {}

  Value value() {
    const Value result = either();
    return at_ == tokens_.size() ? result : std::nullopt;
  }

private:
  bool take(const char* token) {
    if (at_ >= tokens_.size() || tokens_[at_] != token) return false;
    ++at_;
    return true;
  }

  Value either() {
    Value a = both();
    while (take("||")) {
      const Value b = both();
      if ((a && *a) || (b && *b))
        a = 1;
      else
        a = a && b ? Value(0) : std::nullopt;
    }
    return a;
  }

  Value both() {
    Value a = comparison();
    while (take("&&")) {
      const Value b = comparison();
      if ((a && !*a) || (b && !*b))
        a = 0;
      else
        a = a && b ? Value(1) : std::nullopt;
    }
    return a;
  }

  Value comparison() {
    const Value a = sum();
    for (const char* sign : {"==", "!=", "<=", ">=", "<", ">"}) {
      if (!take(sign)) continue;
      const Value b = sum();
      if (!a || !b) return std::nullopt;
      const std::string name = sign;
      return name == "=="   ? *a == *b
             : name == "!=" ? *a != *b
             : name == "<=" ? *a <= *b
             : name == ">=" ? *a >= *b
             : name == "<"  ? *a < *b
                            : *a > *b;
    }
    return a;
  }

  Value sum() {
    Value a = single();
    for (;;) {
      const bool plus = take("+"), minus = !plus && take("-");
      if (!plus && !minus) return a;
      const Value b = single();
      a = a && b ? Value(plus ? *a + *b : *a - *b) : std::nullopt;
    }
  }

  Value single() {
    if (take("!")) {
      const Value a = single();
      return a ? Value(!*a) : std::nullopt;
    }
    if (take("-")) {
      const Value a = single();
      return a ? Value(-*a) : std::nullopt;
    }
    if (take("(")) {
      const Value a = either();
      return take(")") ? a : std::nullopt;
    }
    if (at_ == tokens_.size()) return std::nullopt;
    const std::string token = tokens_[at_++];
    if (token == "defined") {
      const bool bracket = take("(");
      if (at_ == tokens_.size()) return std::nullopt;
      const bool known = macros_.count(tokens_[at_++]) > 0;
      return !bracket || take(")") ? Value(known) : std::nullopt;
    }
    if (std::isdigit(static_cast<unsigned char>(token[0]))) return std::strtol(token.c_str(), nullptr, 0);
    const auto macro = macros_.find(token);
    if (macro == macros_.end() || depth_ > 8) return std::nullopt;
    return Expression(tokens_of(macro->second), macros_, depth_ + 1).value();
  }

  std::vector<std::string> tokens_;
  const Macros& macros_;
  int depth_;
  std::size_t at_ = 0;
};

// One #if that is open: may its present branch be live, and was an earlier one surely taken?
struct Condition {
  bool live, taken;
};

} // namespace

std::set<std::string> names_used(const std::string& text, Macros macros) {
  std::set<std::string> names;
  std::vector<Condition> open{{true, false}};
  std::istringstream in(without_comments(text));
  for (std::string line; std::getline(in, line);) {
    std::vector<std::string> tokens = tokens_of(line);
    if (tokens.empty()) continue;
    const std::string directive = tokens[0] == "#" && tokens.size() > 1 ? tokens[1] : std::string();
    const auto decide = [&]() -> Value {
      std::vector<std::string> rest(tokens.begin() + 2, tokens.end());
      if (directive == "ifdef") rest.insert(rest.begin(), "defined");
      if (directive == "ifndef") rest.insert(rest.begin(), {"!", "defined"});
      return Expression(std::move(rest), macros).value();
    };
    if (directive == "if" || directive == "ifdef" || directive == "ifndef") {
      const Value value = decide();
      open.push_back({open.back().live && (!value || *value), value && *value});
    } else if (directive == "elif" && open.size() > 1) {
      const Value value = open.back().taken ? Value(0) : decide();
      open.back() = {open[open.size() - 2].live && (!value || *value),
                     open.back().taken || (value && *value)};
    } else if (directive == "else" && open.size() > 1) {
      open.back().live = open[open.size() - 2].live && !open.back().taken;
    } else if (directive == "endif" && open.size() > 1) {
      open.pop_back();
    } else if (open.back().live) {
      if (directive == "define" && tokens.size() > 2) {
        const std::size_t value = line.find(tokens[2], line.find("define") + 6) + tokens[2].size();
        macros[tokens[2]] = line.substr(value);
      }
      for (const std::string& token : tokens)
        if (begins_name(token[0])) names.insert(token);
    }
  }
  return names;
}

} // namespace pliant::gl
