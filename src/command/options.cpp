#include "command/options.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <utility>

#include "core/base/named.h"
#include "elastin/core/base/error.h"

namespace elastin::command {
namespace {

constexpr const char* kHelp = "-h,--help";

/// A word that stands for an option and not for a value: "--out", "-q"; neither "-" nor a negative number.
bool is_option(const std::string& word) {
  if (word.starts_with("--")) return true;
  return word.size() > 1 && word.front() == '-' && std::isalpha(static_cast<unsigned char>(word[1]));
}

bool requests_help(const std::string& word) { return word == "-h" || word == "--help"; }

void take(Options::Option& option, const std::string& text) {
  try {
    option.take(text);
  } catch (const InputError& error) {
    throw InputError(option.name + ": " + error.what());
  }
  ++option.given;
}

int whole_number(const std::string& text, int low, int high) {
  int value = 0;
  const auto [end, problem] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (problem != std::errc() || end != text.data() + text.size() || value < low || value > high)
    throw InputError(fmt::format("'{}' is not a whole number from {} to {}", text, low, high));
  return value;
}

std::string head_of(const Options::Option& option) {
  return option.name + (option.value.empty() ? "" : " " + option.value) + (option.required ? " (required)" : "");
}

}  // namespace

Take into(std::string& target) {
  return [&target](const std::string& text) { target = text; };
}

Take into(std::vector<std::string>& target) {
  return [&target](const std::string& text) { target.push_back(text); };
}

Take into(int& target, int low, int high) {
  return [&target, low, high](const std::string& text) { target = whole_number(text, low, high); };
}

Take into(std::vector<int>& target, int low, int high) {
  return [&target, low, high](const std::string& text) { target.push_back(whole_number(text, low, high)); };
}

Take into(double& target, double low, double high) {
  return [&target, low, high](const std::string& text) {
    char* end = nullptr;
    const double value = std::strtod(text.c_str(), &end);
    if (text.empty() || *end != 0 || !std::isfinite(value) || value < low || value > high)
      throw InputError(fmt::format("'{}' is not a number{}", text,
                                   std::isfinite(low) ? fmt::format(" from {:g} to {:g}", low, high) : ""));
    target = value;
  };
}

Take one_of(std::vector<std::string> allowed, Take take) {
  return [allowed = std::move(allowed), take = std::move(take)](const std::string& text) {
    if (std::find(allowed.begin(), allowed.end(), text) == allowed.end())
      throw InputError("'" + text + "' is not known" + suggestion(text, allowed));
    take(text);
  };
}

Take each_of(Take take) {
  return [take = std::move(take)](const std::string& text) {
    for (std::size_t from = 0; from < text.size();) {
      const std::size_t to = std::min(text.find(',', from), text.size());
      if (to > from) take(text.substr(from, to - from));
      from = to + 1;
    }
  };
}

void Options::flag(const std::string& name, bool& target, const std::string& help) {
  add(
      name, "", [&target](const std::string&) { target = true; }, help)
      .repeated = true;
}

Options::Option& Options::add(const std::string& name, const std::string& value, Take take, const std::string& help) {
  return options_.emplace_back(Option{name, value, help, std::move(take)});
}

void Options::argument(const std::string& name, Take take, const std::string& help, bool required, bool repeated) {
  arguments_.push_back({name, "", help, std::move(take), required, repeated});
}

Options::Option& Options::find(const std::string& name) {
  if (Option* found = find_named(options_, name)) return *found;
  std::vector<std::string> known;
  for (const Option& option : options_)
    if (!option.hidden) known.push_back(option.name);
  known.emplace_back("--help");
  throw InputError("unknown option '" + name + "'" + suggestion(name, known));
}

void Options::take_argument(const std::string& word, const std::string& usage_name) {
  for (Option& argument : arguments_)
    if (argument.repeated || argument.given == 0) return take(argument, word);
  throw InputError("'" + word + "' is one argument too many; write " + usage(usage_name));
}

void Options::check_complete(const std::string& usage_name) const {
  for (const auto* list : {&arguments_, &options_})
    for (const Option& option : *list)
      if (option.required && option.given == 0)
        throw InputError(head_of({option.name, option.value, "", {}}) + " is missing; write " + usage(usage_name));
}

bool Options::read(const std::vector<std::string>& words, const std::string& usage_name) {
  bool options_end = false;
  for (std::size_t i = 0; i < words.size(); ++i) {
    const std::string& word = words[i];
    if (options_end || !is_option(word)) {
      take_argument(word, usage_name);
      continue;
    }
    if (requests_help(word)) return true;
    if ((options_end = word == "--")) continue;
    const std::size_t equals = word.starts_with("--") ? word.find('=') : std::string::npos;
    Option& option = find(word.substr(0, equals));
    if (option.given > 0 && !option.repeated) throw InputError(option.name + " is given twice; give it once");
    if (option.value.empty()) {
      if (equals != std::string::npos) throw InputError(option.name + " takes no value; write " + option.name);
      take(option, "");
    } else {
      const bool next = equals == std::string::npos && i + 1 < words.size() && !is_option(words[i + 1]);
      const std::string value = next ? words[++i] : equals == std::string::npos ? "" : word.substr(equals + 1);
      if (value.find_first_not_of(' ') == std::string::npos)
        throw InputError(option.name + " needs a value" +
                         (next || equals != std::string::npos ? ", not an empty one" : "") + "; write " + option.name +
                         " " + option.value);
      take(option, value);
    }
  }
  check_complete(usage_name);
  return false;
}

std::string Options::usage(const std::string& usage_name) const {
  std::string text = usage_name;
  for (const Option& argument : arguments_) {
    const std::string name = argument.name + (argument.repeated ? "..." : "");
    text += " " + (argument.required ? name : "[" + name + "]");
  }
  for (const Option& option : options_)
    if (option.required) text += " " + option.name + " " + option.value;
  return text + " [OPTIONS]";
}

std::string help_line(const std::string& name, const std::string& text) {
  constexpr std::size_t column = 28;
  const std::string head = "  " + name;
  if (head.size() < column) return fmt::format("{:{}}{}\n", head, column, text);
  return fmt::format("{}\n{:{}}{}\n", head, "", column, text);
}

std::string Options::help(const std::string& usage_name) const {
  std::string text = "Usage: " + usage(usage_name) + "\n";
  if (!arguments_.empty()) text += "\nArguments:\n";
  for (const Option& argument : arguments_)
    text += help_line(argument.name + (argument.repeated ? "..." : ""), argument.help);
  text += "\nOptions:\n" + help_line(kHelp, "Print this help");
  for (const Option& option : options_)
    if (!option.hidden) text += help_line(head_of(option), option.help);
  return text;
}

}  // namespace elastin::command
