#pragma once
#include <string>
#include <vector>

namespace elastin::config {

/// Of the `known` keys the one that a key means which is written as a symbol ("E"), in other words ("elongation") or
/// with other capitals, blanks and hyphens; "" where it means none of them.
std::string meant_key(const std::string& given, const std::vector<std::string>& known);

/// The tail of a message about a word that is not among `names`, as suggestion() has it, with synonyms too:
/// "fixed" means `clamped`.
std::string suggested_word(const std::string& word, const std::vector<std::string>& names);

/// What there is in place of a key that scenes do not have: "units stand behind each number"; "" of others.
std::string instead_of_key(const std::string& given);

/// "40 x 10 x 4 mm", "8x2x1", "8 2 1" as a list, "[40 mm, 10 mm, 4 mm]"; "" of a text that is no such thing.
std::string as_list(const std::string& text);

/// "write [4, 4.5 mm, …]": what a list of `given` values is that has a decimal comma and is to have `count`; "" where
/// it has none.
std::string with_decimal_points(const std::vector<std::string>& given, std::size_t count);

}  // namespace elastin::config
