#pragma once

#include "c/handles.h"
#include "lab/live/parcel.h"
#include "web/lab.h"

struct elastin_lab {
  elastin::lab::Parcel parcel;
  /// The scene's material under these settings.
  elastin::Material material(const elastin_lab_settings& settings) const;
  /// The simulation of these settings; `alone`: for the test, without supports, where it is at rest, under
  /// the scene's own weight where the test is the scene's.
  elastin::Simulation simulation(const elastin_lab_settings& settings, bool alone) const;
};
