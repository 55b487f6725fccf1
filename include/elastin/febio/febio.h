#pragma once

namespace elastin::febio {

/// Lets the lab read FEBio's models: from then on a file *.feb is a scene for it, of the format 4.0, module solid.
/// Numbers count as SI. An element that has no equal in Elastin, or is not known, is an InputError with the file, the
/// line and the element's name; output, plots and the settings of FEBio's solver alone are passed over. A second call
/// changes nothing.                                                       [Maas et al. 2012; FEBio User's Manual 4.0]
void add_scene_format();

}  // namespace elastin::febio
