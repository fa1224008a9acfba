// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What tears tissue that jaws hold, in newtons a metre of the grasped width.

namespace pbdsurg::tear_strength {

/// Liver: 0.3 +- 0.3 N/mm tear the capsule of humans and pigs, at a local strain of 47 +- 29 %
/// (abstract at wbldb.lievers.net/10186966).
inline constexpr float kLiver = 300;

/// Gallbladder: 1.83 MPa tear the wall of pigs at 500 %/s (J. Biomech. 2020, PMID 32807339), here
/// of a wall of 2.5 mm. A slow pull tears it sooner.
inline constexpr float kGallbladderWall = 4600;

/// A placeholder for all other tissue, until somebody measures it: no source was found.
inline constexpr float kPlaceholder = 1000;

}  // namespace pbdsurg::tear_strength
