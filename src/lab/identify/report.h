#pragma once
#include <string>
#include <vector>

#include "lab/identify/answer.h"
#include "lab/report/plot.h"

namespace elastin::lab {

/// The tables of the terminal: numbers with intervals, tests, laws, warnings, the material.
std::string answer_text(const Answer& answer, bool colours);

/// What each strategy makes of the same curve: its numbers, its misfit and its time; "" of one answer.
std::string strategies_text(const std::vector<Answer>& answers, bool colours);

/// {"law", "parameters": [{name, value, unit, low, high}], "correlation": [[…]], "relative_rms": {test: …}, "warnings":
/// [], …} of one answer; of several {"identifications": [{…}, …]}. SI units; what is not finite is null.
std::string identify_json(const std::vector<Answer>& answers);

/// One HTML page that needs no other file: data with fits, residuals, intervals, correlation, laws, warnings.
std::string identify_page(const std::vector<Answer>& answers, const std::string& command);

/// Data and fits; the residuals of each point.
Plot fit_plot(const Answer& answer);
Plot residual_plot(const Answer& answer);
/// Misfit over the time of the fit, of strategies.
Plot strategy_plot(const std::vector<Answer>& answers);

/// Every measured point with its fit: test, prescribed, measured, fitted, residual.
std::string points_csv(const Answer& answer);

}  // namespace elastin::lab
