#pragma once
#include <string>

#include "lab/report/plot.h"

namespace elastin::lab {

/// A page up to its header's text: it needs no other file.
std::string page_begin(const std::string& title, const std::string& brand);

/// A plot, wide and narrow, that can be saved under a name; nothing where it has no series.
std::string figure_html(const Plot& plot, const std::string& heading, const std::string& name);

/// A heading with HTML below it.
std::string card_html(const std::string& heading, const std::string& inside);

}  // namespace elastin::lab
