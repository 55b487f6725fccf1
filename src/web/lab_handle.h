#pragma once

#include "c/handles.h"
#include "lab/live/parcel.h"
#include "web/lab.h"

struct elastin_lab {
  elastin::lab::Parcel parcel;
  /// The scene's material under these settings.
  elastin::Material material(const elastin_lab_settings& settings) const;
  /// The simulation of these settings; `alone`: without the scene's supports, and where it is at rest.
  elastin::Simulation simulation(const elastin_lab_settings& settings, bool alone) const;
};
