#include "elastin/core/simulation/strategy_name.h"

#include <algorithm>
#include <array>
#include <string_view>
#include <utility>
#include <vector>

#include "elastin/core/base/error.h"

namespace elastin {
namespace {

struct Property {
  std::string_view word;
  bool StrategyName::*has;
};

/// In the order in which they stand in a name.
constexpr std::array kBeginnings{
    Property{"prony:", &StrategyName::relaxed}, Property{"mullins:", &StrategyName::softened},
    Property{"calibrated:", &StrategyName::calibrated}, Property{"fitted:", &StrategyName::fitted}};
constexpr std::array kEndings{Property{"+volume", &StrategyName::volume},
                              Property{"+wrinkling", &StrategyName::wrinkling}};
constexpr std::string_view kMembrane = "_membrane";

template <class Properties>
void check_word(const std::string& rule, const std::string& word, const char* kind, const Properties& properties) {
  std::vector<std::string> known;
  for (const Property& property : properties) known.emplace_back(property.word);
  if (std::find(known.begin(), known.end(), word) == known.end())
    throw InputError("'" + rule + "': unknown " + kind + " '" + word + "'" + suggestion(word, known));
  throw InputError("'" + rule + "': '" + word +
                   "' is repeated or misplaced; the order is prony:mullins:calibrated:RULE+volume+wrinkling");
}

}  // namespace

StrategyName::StrategyName(std::string text) : rule(std::move(text)) {
  for (const auto& [word, has] : kBeginnings)
    if (rule.starts_with(word)) rule.erase(0, word.size()), this->*has = true;
  for (auto ending = kEndings.rbegin(); ending != kEndings.rend(); ++ending)
    if (rule.ends_with(ending->word)) rule.erase(rule.size() - ending->word.size()), this->*(ending->has) = true;
  for (const auto has : {&StrategyName::calibrated, &StrategyName::fitted})
    if (!calibrated && !fitted && rule == (has == &StrategyName::fitted ? "fitted" : "calibrated"))
      this->*has = true, rule = "standard";
}

StrategyName StrategyName::of_law(const std::string& law, int dimensions) {
  return StrategyName(dimensions == 2 ? law + std::string(kMembrane) : law);
}

std::string StrategyName::text() const {
  std::string text;
  for (const auto& [word, has] : kBeginnings)
    if (this->*has) text += word;
  text += rule;
  for (const auto& [word, has] : kEndings)
    if (this->*has) text += word;
  return text;
}

bool StrategyName::of_membrane() const { return rule.ends_with(kMembrane); }

std::string StrategyName::law() const { return of_membrane() ? rule.substr(0, rule.size() - kMembrane.size()) : rule; }

void StrategyName::check() const {
  if (const auto plus = rule.find('+'); plus != std::string::npos)
    check_word(text(), rule.substr(plus), "ending", kEndings);
  if (const auto colon = rule.find(':'); colon != std::string::npos)
    check_word(text(), rule.substr(0, colon + 1), "beginning", kBeginnings);
}

}  // namespace elastin
