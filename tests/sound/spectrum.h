// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What samples sound like.

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstddef>
#include <numbers>
#include <span>

#include "apps/sound/tones.h"

namespace cholecystectomy {

/// Amplitude of one frequency.
/// @param frequency  Hz
template <class Sample>
double amplitude_at(std::span<const Sample> samples, double frequency) {
  std::complex<double> sum = 0;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    sum +=
        static_cast<double>(samples[i]) *
        std::polar(1.0, -2 * std::numbers::pi * frequency * static_cast<double>(i) / kSampleRate);
  }
  return 2 * std::abs(sum) / static_cast<double>(samples.size());
}

/// The strongest of 100, 110, ... 2000 Hz.
template <class Sample>
double dominant_frequency(std::span<const Sample> samples) {
  double best = 0, frequency = 0;
  for (int candidate = 100; candidate <= 2000; candidate += 10) {
    const double amplitude = amplitude_at(samples, candidate);
    if (amplitude > best) {
      best = amplitude;
      frequency = candidate;
    }
  }
  return frequency;
}

/// The largest change of slope from a sample to the next: a click is a large one.
template <class Sample>
double sharpest_bend(std::span<const Sample> samples) {
  double sharpest = 0;
  for (std::size_t i = 2; i < samples.size(); ++i) {
    sharpest = std::max(sharpest, std::abs(static_cast<double>(samples[i]) -
                                           2 * static_cast<double>(samples[i - 1]) +
                                           static_cast<double>(samples[i - 2])));
  }
  return sharpest;
}

}  // namespace cholecystectomy
