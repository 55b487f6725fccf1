#pragma once
#include <string>

namespace elastin {

/// The name of a strategy, read: `prony:mullins:calibrated:patch+volume` is the rule `patch` with four properties.
/// Beginnings and endings count once each and in this order: prony:mullins:calibrated:RULE+volume+wrinkling; `fitted:`
/// stands in place of `calibrated:`.
struct StrategyName {
  std::string rule;         ///< its row in the catalog; whatever is left of a text that is no name of this form
  bool relaxed = false;     ///< "prony:", see with_relaxation
  bool softened = false;    ///< "mullins:", see with_softening
  bool calibrated = false;  ///< "calibrated:", see calibrated; the word alone is calibrated:standard
  bool fitted = false;      ///< "fitted:", see fitted; the word alone is fitted:standard
  bool volume = false;      ///< "+volume", see with_volume
  bool wrinkling = false;   ///< "+wrinkling", see with_wrinkling

  StrategyName() = default;
  /// Reads a name; any text is read.
  explicit StrategyName(std::string text);
  /// The plain strategy of a law on cells of 2 or 3 dimensions.
  static StrategyName of_law(const std::string& law, int dimensions);

  /// The name, written back.
  std::string text() const;
  /// The law or rule without what says that it is one of membranes: "curve" of curve_membrane.
  std::string law() const;
  /// Whether the rule is that of a membrane law.
  bool of_membrane() const;
  /// Throws InputError on what is left in the rule of unknown, repeated or misplaced beginnings and endings.
  void check() const;
};

}  // namespace elastin
