#include <mutex>

#include "elastin/febio/febio.h"
#include "febio/model.h"
#include "lab/scene/scene.h"

namespace elastin::febio {

void add_scene_format() {
  static std::once_flag added;
  std::call_once(added, [] {
    lab::scene_formats().add({{"febio", "model of FEBio", "FEBio User's Manual 4.0"}, ".feb", load_model});
  });
}

}  // namespace elastin::febio
