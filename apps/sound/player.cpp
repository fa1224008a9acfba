// SPDX-License-Identifier: Apache-2.0
#include "apps/sound/player.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <system_error>

#include "pbdsurg/base/error.h"

#if defined(PBDSURG_HAS_OPENAL)
#include "apps/sound/openal_output.h"
#include "apps/sound/threaded_player.h"
#endif

namespace cholecystectomy {
namespace {

#if defined(__linux__)
// By the device files, as ALSA looks for them.
bool has_alsa_card() {
  std::error_code error;
  std::filesystem::directory_iterator file("/dev/snd", error);
  for (; !error && file != std::filesystem::directory_iterator(); file.increment(error)) {
    if (file->path().filename().string().starts_with("controlC")) {
      return true;
    }
  }
  return false;
}
#endif

class SilentPlayer final : public SoundPlayer {
 public:
  explicit SilentPlayer(const std::string& reason) : status_("no sound: " + reason) {}

  void set_tone(Tone /*tone*/) override {}
  void play(Chime /*chime*/) override {}
  [[nodiscard]] const std::string& status() override { return status_; }

 private:
  void change_volume(float /*volume*/) override {}

  std::string status_;
};

}  // namespace

void SoundPlayer::set_volume(float volume) {
  if (std::isnan(volume)) {
    throw pbdsurg::InvalidArgument("the volume of sounds is " + std::to_string(volume) +
                                   "; it must be a number, 0 silent to 1");
  }
  change_volume(std::clamp(volume, 0.0f, 1.0f));
}

std::unique_ptr<SoundPlayer> make_silent_player(const std::string& reason) {
  return std::make_unique<SilentPlayer>(reason);
}

void quiet_openal() {
  setenv("ALSOFT_LOGLEVEL", "0", 0);
#if defined(__linux__)
  if (!has_alsa_card()) {
    setenv("ALSOFT_DRIVERS", "-alsa,-sndio,", 0);  // sndio asks ALSA in turn
  }
#endif
}

std::unique_ptr<SoundPlayer> make_player() {
#if defined(PBDSURG_HAS_OPENAL)
  quiet_openal();
  try {
    return std::make_unique<ThreadedPlayer>([] { return std::make_unique<OpenAlOutput>(); });
  } catch (const std::exception& error) {
    return make_silent_player(error.what());
  }
#else
  return make_silent_player("built without OpenAL");
#endif
}

}  // namespace cholecystectomy
