// SPDX-License-Identifier: Apache-2.0
// The check of a rig with a person at the terminal, sound and pictures.
#include <array>
#include <chrono>
#include <cstdio>
#include <memory>
#include <thread>
#include <utility>

#include <unistd.h>

#include "pbdsurg/base/error.h"

#include "apps/cholecystectomy/interruption.h"
#include "apps/cholecystectomy/play/places.h"
#include "apps/cholecystectomy/play/rig_check.h"
#include "apps/cholecystectomy/play/scene_feed.h"
#include "apps/sound/player.h"
#ifdef PBDSURG_HAS_PICTURES
#include "apps/viewer/offscreen_renderer.h"
#endif

namespace cholecystectomy {
namespace {

void tell(const std::string& text) {
  std::printf("%s\n", text.c_str());
  std::fflush(stdout);
}

std::optional<bool> ask(const std::string& question) {
  if (isatty(STDIN_FILENO) == 0) {
    return std::nullopt;
  }
  tell(question + " [y/n]");
  std::array<char, 16> answer{};
  if (std::fgets(answer.data(), answer.size(), stdin) == nullptr) {
    return std::nullopt;
  }
  return answer[0] == 'y' || answer[0] == 'Y';
}

std::string sound() {
  const std::unique_ptr<SoundPlayer> player = make_player();
  const auto wait = [] { std::this_thread::sleep_for(std::chrono::milliseconds(700)); };
  for (const Tone tone : {Tone::cut, Tone::coagulation, Tone::none}) {
    player->set_tone(tone);
    wait();
  }
  player->play(Chime::warning);
  wait();
  return player->status();
}

std::optional<std::pair<double, std::string>> draw() {
#ifdef PBDSURG_HAS_PICTURES
  constexpr int kPictures = 20;
  try {
    const LoadedAnatomy anatomy = load_anatomy({}, Detail::low);
    const SurgicalScene scene = make_scene(anatomy, pbdsurg::ElasticModel::neo_hookean);
    OffscreenRenderer renderer({.width = 1280, .height = 720, .quality = RenderQuality::quick()});
    renderer.set_surfaces(rest_surfaces(scene, anatomy.anatomy.abdominal_wall));
    SceneView view;
    view.camera = first_scope().camera();
    renderer.draw(view);  // the first makes its programs
    const auto start = std::chrono::steady_clock::now();
    for (int i = 0; i < kPictures; ++i) {
      renderer.draw(view);
    }
    const std::chrono::duration<double, std::milli> time = std::chrono::steady_clock::now() - start;
    return std::pair(time.count() / kPictures, renderer.device_name());
  } catch (const pbdsurg::BackendUnavailable&) {
  }
#endif
  return std::nullopt;
}

}  // namespace

int check_rig_at_terminal(const RigCheckOptions& options) {
  quiet_openal();
  note_interrupt();
  const std::vector<RigCheckLine> lines = check_rig(options, {tell, ask, sound, draw});
  tell(sheet_of(lines, options.devices));
  for (const RigCheckLine& line : lines) {
    if (line.result == RigCheckLine::Result::failed) {
      return 1;
    }
  }
  return 0;
}

}  // namespace cholecystectomy
