// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Which devices a rig has, as a person says it: by a word, or in a file.

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "pbdsurg/base/error.h"
#include "pbdsurg/haptics/handle.h"
#include "pbdsurg/haptics/instrument_mapping.h"
#include "pbdsurg/haptics/pedal_keyboard.h"
#include "pbdsurg/haptics/servo.h"

namespace rig {

enum class Side : std::uint8_t { left, right };
inline constexpr std::array<Side, 2> kSides{Side::left, Side::right};
[[nodiscard]] constexpr const char* name_of(Side side) {
  return side == Side::left ? "left" : "right";
}

/// What moves an instrument.
enum class Mover : std::uint8_t {
  mouse,  ///< of the window
  arm,    ///< a haptic device by HDAPI
  trace,  ///< a recorded hand
};

struct HandleDescription {
  std::filesystem::path port;
  pbdsurg::JawRange range;
};

/// One hand.
struct HandDescription {
  Mover mover = Mover::mouse;
  // of an arm
  std::string arm_name{};       ///< as in the vendor's setup tool; empty: its default device
  std::string serial_number{};  ///< that it must have; empty: any
  pbdsurg::HeldPart held = pbdsurg::HeldPart::tip;
  float motion_scale = 1;  ///< see pbdsurg::InstrumentMappingOptions
  /// See pbdsurg::ServoOptions. Instruments pull with up to 12 N, a Touch does 0.88 N for long.
  float force_scale = 0.25F;
  bool is_firm = false;                       ///< likewise
  pbdsurg::ServoMode servo{};                 ///< likewise
  std::optional<HandleDescription> handle{};  ///< else a button of the arm closes the jaws
  // of a trace
  std::filesystem::path trace{};
};

struct PedalsDescription {
  std::filesystem::path keyboard;
  pbdsurg::PedalKeys keys;
};

/// Something that goes wrong with an emulated arm.
struct FaultDescription {
  std::string fault;  ///< as hdapi_emulator::name_of() has it
  Side side = Side::left;
  double begin = 0;  ///< s after the first scene began; 0: from the opening of arms on
  double duration = std::numeric_limits<double>::infinity();  ///< s
};

struct RigDescription {
  bool is_emulated = false;              ///< its arms
  std::array<HandDescription, 2> hands;  ///< [side]
  std::vector<PedalsDescription> pedals;
  std::vector<FaultDescription> faults;

  [[nodiscard]] const HandDescription& hand(Side side) const {
    return hands[static_cast<std::size_t>(side)];
  }
  [[nodiscard]] bool has(Mover mover) const {
    return hands[0].mover == mover || hands[1].mover == mover;
  }
};

/// A rig by a word for both hands, or two with a comma between them, left first:
///
/// | word                                | is                                                     |
/// |-------------------------------------|--------------------------------------------------------|
/// | mouse                               | a hand moved by the mouse                              |
/// | openhaptics                         | an arm; for both hands "Left Device", "Right Device"   |
/// | emulator                            | an emulated arm, in a hand that follows a script       |
/// | FILE that begins as a device trace  | a recorded hand; alone it is the right, the left rests |
/// | any other FILE, alone               | a rig in JSON: docs/rig.md has its keys                |
///
/// @throws pbdsurg::InvalidArgument  naming the word, if there are more than two, or arms of both
///                                   kinds
/// @throws pbdsurg::FileError        naming the file, the key, the value and the rule
[[nodiscard]] RigDescription read_rig(const std::string& devices);

}  // namespace rig
