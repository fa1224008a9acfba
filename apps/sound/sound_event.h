// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What is to be heard in the operating room. How it sounds is in tones.h, who plays it in
/// player.h.

#include <cstddef>
#include <variant>

namespace cholecystectomy {

/// What an electrosurgical generator sounds for as long as it is active.
enum class Tone { none, cut, coagulation };

/// What sounds once.
enum class Chime {
  refused,  ///< an activation: both pedals are down, or there is nothing to activate
  warning,  ///< something that the trainee must notice
};

inline constexpr std::size_t kToneCount = 3;
inline constexpr std::size_t kChimeCount = 2;

/// A change of the tone, or a chime.
using SoundEvent = std::variant<Tone, Chime>;

/// For people: "cut".
[[nodiscard]] const char* name_of(Tone tone) noexcept;

/// For people: "activation refused".
[[nodiscard]] const char* name_of(Chime chime) noexcept;

}  // namespace cholecystectomy
