#pragma once
#include "elastin/lab/run/experiment.h"

namespace elastin::febio {

using lab::MainMeasure;
using lab::MeasureList;
using lab::Measures;
using lab::Start;
using lab::StaticExperiment;
using lab::StaticRig;

}  // namespace elastin::febio
