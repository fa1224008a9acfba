// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// All texts of the window. A translation is another Texts; what is a format keeps its % signs.

#include <array>

#include "apps/cholecystectomy/play/scene_state.h"

namespace cholecystectomy {

struct KeyText {
  const char* keys;
  const char* what;
};

struct Texts {
  const char* title = "Laparoscopic cholecystectomy";
  const char* disclaimer =
      "Not a medical device. Not validated: nothing here teaches or proves surgical skill.";
  const char* understood = "I understand";
  const char* loading = "Making organs and their solver ...";
  const char* failed = "The scene cannot go on: %s";
  const char* close = "Close";

  const char* operation = "Operation";
  const char* chosen_left = "Mouse moves: left hand";
  const char* chosen_right = "Mouse moves: right hand";
  const char* devices_hold = "Devices move both hands, the mouse the scope";
  const char* grasper = "grasper";
  const char* hook = "hook";
  const char* choose_other = "Other hand (Tab)";
  const char* close_jaw = "Close jaws (G)";
  const char* open_jaw = "Open jaws (G)";
  const char* undo = "Undo (Z)";
  const char* restart = "Restart (Shift R)";
  const char* pause = "Pause (P)";
  const char* go_on = "Go on (P)";
  const char* single_step = "Step (.)";
  const char* slow_motion = "Slow (,)";
  const char* deeper = "Deeper (W)";
  const char* nearer = "Nearer (S)";
  const char* swap_hands = "Swap hands (X)";
  const char* help = "Help (H)";
  const char* instrument = "Instrument";
  const char* roll_left = "Roll left (Q)";
  const char* roll_right = "Roll right (E)";
  const char* scene = "Scene";
  const char* scope = "Scope";
  const char* scope_in = "Closer";
  const char* scope_out = "Farther";
  const char* look_left = "Look left";
  const char* look_right = "Look right";
  const char* look_up = "Look up";
  const char* look_down = "Look down";
  const char* post_left = "Post left (A)";
  const char* post_right = "Post right (D)";
  const char* head_left = "Head left ([)";
  const char* head_right = "Head right (])";
  const char* level = "Level (L)";
  const char* follow_tips = "Follow tips (F)";
  const char* program = "Program";
  const char* full_screen = "Full screen (F11)";
  const char* screenshot = "Screenshot (F12)";
  const char* removed = "removed %lld tetrahedra, parted %lld strands";

  const char* generator = "Generator";
  const char* cut = "CUT (C)";
  const char* coagulation = "COAG (V)";
  const char* cut_power = "cut, W";
  const char* coagulation_power = "coag, W";
  const char* delivered = "%.0f W   %.0f V   %s";
  const char* resistance = "%.0f ohm";
  const char* open_circuit = "open";
  const char* hottest = "hottest %.0f C   spent %.0f J";
  const char* both_pedals = "both pedals: no current";
  const char* sparks = "sparks";

  const char* forces = "Forces";
  const char* force_on_grasper = "grasper %.1f N, %.0f mm away";
  const char* force_on_hook = "hook %.1f N, %.0f mm away";

  std::array<const char*, 2> sides{"left", "right"};
  const char* hand_line = "%s, %s: %.2f N of %.2f N, %s";  // commanded, computed
  const char* hand_fine = "force on";
  const char* hand_engaging = "force is let in while nothing is touched";
  const char* hand_not_calibrated = "no force: not calibrated";
  const char* hand_lost = "no force: not connected";
  const char* arm_lost =
      "The %s arm is lost. It goes on without force; check cable and power, then start again.";
  const char* arm_silent = "The %s arm is silent.";
  const char* arm_inkwell = "Park the %s stylus in its inkwell, and take it out again.";
  const char* arm_stuck = "The %s arm does not calibrate: unplug it, plug it in, start again.";
  const char* arm_warm = "The motors of the %s arm are warm: no force until they have cooled.";
  const char* handle_lost = "The handle in the %s hand is silent: its jaws open.";
  const char* handle_back = "The handle in the %s hand is back.";
  const char* pedals_lost = "A pedal's keyboard is gone: pedals are up until it is back.";
  const char* trace_over = "The recorded %s hand has come to its end.";

  const char* in_time = "%.1f s, in real time";
  const char* stretched = "%.1f s, TIME STRETCHED by %.2f";
  const char* paused = "%.1f s, paused";
  const char* pictures = "%.0f pictures/s, %.1f ms each";
  const char* step_times = "step: heat %.1f, edits %.1f, solver %.1f, surfaces %.1f ms";
  const char* publish_time = "for pictures %.1f ms";

  const char* settings = "Settings";
  const char* volume = "volume";
  const char* size = "size of texts";
  const char* motion = "hand motion";
  const char* quality = "pictures";
  std::array<const char*, 3> qualities{"automatic", "quick", "full"};  // [PictureQuality]
  const char* low_detail = "coarse organs (from the next start)";

  /// [Event] empty: not worth a word
  std::array<const char*, kEventCount> events{
      "",
      "The jaws closed on nothing: move the tip to an organ first.",
      "The tissue slipped out of the jaws: too much force.",
      "The last stroke was taken back.",
      "There is no stroke to take back.",
      "The scene begins anew.",
      "The tissue lost its shape, and the scene begins anew.",
      "",
      ""};

  /// Of the first minute; each goes when it was done.
  std::array<const char*, 6> guide{
      "Drag with the left button to move the grasper; the wheel moves it into the picture.",
      "Touch the gallbladder with the tip and press G: the jaws close.",
      "Pull gently. The force is in the panel.",
      "Press Tab: the mouse now moves the hook. Bring it to the yellow fat.",
      "Hold C to cut, V to coagulate. Both together do nothing.",
      "Drag with the right button to turn the scope; the wheel with it slides the scope."};
  const char* guide_done = "That is all. H shows every key.";

  std::array<KeyText, 20> keys{
      {{"left button", "drag the chosen instrument in the plane of the picture"},
       {"wheel, W, S", "move it along the view"},
       {"Tab", "choose the other hand"},
       {"G, Space, middle button", "close or open the jaws"},
       {"Q, E", "roll the instrument"},
       {"C", "pedal: cut, while held"},
       {"V", "pedal: coagulate, while held"},
       {"right button", "turn the scope about its port"},
       {"right button + wheel", "slide the scope"},
       {"A, D", "turn the light post: the oblique view goes around"},
       {"[, ], L", "turn the camera head; level it again"},
       {"F", "the scope keeps both tips in view, until you move it"},
       {"Z", "take the last stroke back: one press of a pedal, one grasp"},
       {"P, .", "pause; one step"},
       {",", "slow motion"},
       {"X", "swap hands and begin anew: the hook in the left"},
       {"Shift R", "begin anew"},
       {"F11, F12", "fill the screen; write a screenshot"},
       {"F9", "make the window anew, if pictures are broken"},
       {"H, Esc", "this page; leave"}}};
};

inline constexpr Texts kEnglish{};

}  // namespace cholecystectomy
