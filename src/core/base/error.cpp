#include "elastin/core/base/error.h"

#include <algorithm>
#include <numeric>

#include "core/base/named.h"

namespace elastin {
namespace {

/// Optimal string alignment distance: insertions, deletions, replacements and swaps of neighbours each count one.
std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::vector<std::size_t>> table(a.size() + 1, std::vector<std::size_t>(b.size() + 1));
  for (std::size_t i = 0; i <= a.size(); ++i) table[i][0] = i;
  std::iota(table[0].begin(), table[0].end(), 0);
  for (std::size_t i = 1; i <= a.size(); ++i)
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t replace = table[i - 1][j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1);
      table[i][j] = std::min({replace, table[i - 1][j] + 1, table[i][j - 1] + 1});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
        table[i][j] = std::min(table[i][j], table[i - 2][j - 2] + 1);
    }
  return table[a.size()][b.size()];
}

/// Without capitals, and without the blanks, hyphens and underscores behind its first letter.
std::string without_marks(std::string_view word) {
  std::string letters;
  for (const char letter : word)
    if (letters.empty() || (letter != ' ' && letter != '-' && letter != '_'))
      letters += letter >= 'A' && letter <= 'Z' ? static_cast<char>(letter - 'A' + 'a') : letter;
  return letters;
}

}  // namespace

std::string SourceLocation::text() const {
  std::string text = file;
  if (line > 0) text.append(":").append(std::to_string(line));
  if (line > 0 && column > 0) text.append(":").append(std::to_string(column));
  return text;
}

std::string nearest_name(std::string_view word, const std::vector<std::string>& candidates) {
  for (const std::string& candidate : candidates)
    if (!word.empty() && without_marks(candidate) == without_marks(word)) return candidate;
  std::string best;
  std::size_t least = std::max<std::size_t>(2, word.size() / 3) + 1;
  for (const std::string& candidate : candidates) {
    const std::size_t distance = edit_distance(word, candidate);
    if (distance < least && distance < candidate.size()) {
      least = distance;
      best = candidate;
    }
  }
  return best;
}

std::string suggestion(std::string_view word, const std::vector<std::string>& candidates) {
  const std::string near = nearest_name(word, candidates);
  std::string text = near.empty() ? "" : "; did you mean '" + near + "'?";
  text += (near.empty() ? "; allowed: " : " (allowed: ") + joined(candidates);
  return near.empty() ? text : text + ")";
}

}  // namespace elastin
