#pragma once
#include "core/model/visit_body.h"
#include "elastin/lab/study/laboratory.h"

/// The one description of what a result is made of, for programs that keep results; see core/base/archive.h.
namespace elastin::lab {

template <class Archive>
void visit(Archive& archive, Measured& measured) {
  archive.word(measured.name);
  archive.word(measured.unit);
  visit(archive, measured.value);
}

template <class Archive>
void visit(Archive& archive, LaboratoryResult::Row& row) {
  visit(archive, row.at);
  visit_all(archive, row.measures);
}

template <class Archive>
void visit(Archive& archive, LaboratoryResult::Kept& kept) {
  visit(archive, kept.at);
  visit(archive, kept.positions);
}

template <class Archive>
void visit(Archive& archive, LaboratoryResult& result) {
  int outcome = static_cast<int>(result.outcome), suited = result.suited, good = result.good;
  for (int* value : {&outcome, &suited, &good, &result.newton_iterations, &result.linear_iterations})
    archive.whole(*value);
  result.outcome = static_cast<Outcome>(outcome), result.suited = suited != 0, result.good = good != 0;
  for (std::string* word : {&result.strategy, &result.cause, &result.solver}) archive.word(*word);
  visit_all(archive, result.measures);
  visit_all(archive, result.main);
  visit_all(archive, result.errors);
  visit_all(archive, result.curve);
  int stiffness = result.stiffness.has_value();
  archive.whole(stiffness);
  if (stiffness && !result.stiffness) result.stiffness.emplace();
  if (stiffness) archive.numbers(result.stiffness->data(), 36);
  visit(archive, result.positions);
  visit(archive, result.tensions);
  visit_all(archive, result.states);
  visit_all(archive, result.warnings);
  for (double* value : {&result.build_seconds, &result.solve_seconds}) visit(archive, *value);
}

}  // namespace elastin::lab
