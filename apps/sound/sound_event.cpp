// SPDX-License-Identifier: Apache-2.0
#include "apps/sound/sound_event.h"

namespace cholecystectomy {

const char* name_of(Tone tone) noexcept {
  switch (tone) {
    case Tone::none:
      return "no tone";
    case Tone::cut:
      return "cut";
    case Tone::coagulation:
      return "coagulation";
  }
  return "unknown tone";
}

const char* name_of(Chime chime) noexcept {
  switch (chime) {
    case Chime::refused:
      return "activation refused";
    case Chime::warning:
      return "warning";
  }
  return "unknown chime";
}

}  // namespace cholecystectomy
