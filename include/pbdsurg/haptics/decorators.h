// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Devices made of others. Each is a device like any other, so that they go into one another:
///
///     Handle handle("/dev/serial/by-id/usb-Arduino_LLC_Arduino_Micro-if00", range, clock);
///     auto hand = with_handle(transformed(scaled(std::move(arm), {.motion = 2}), rig), handle);
///
/// Forces go the other way, from the scene through each to the motors. All run on the thread that
/// asks, allocate nothing once they are made, and show the name of the device within.

#include <Eigen/Geometry>
#include <memory>

#include "pbdsurg/base/error.h"
#include "pbdsurg/base/export.h"
#include "pbdsurg/haptics/device.h"
#include "pbdsurg/haptics/handle.h"
#include "pbdsurg/haptics/pedal_keyboard.h"

namespace pbdsurg {

/// How far and how strong.
struct DeviceScale {
  float motion = 1;                                  ///< scene's per hand's; above 0
  float force = 1;                                   ///< hand's per scene's; 0 or more
  Eigen::Vector3f centre = Eigen::Vector3f::Zero();  ///< m, what stays where it is
};

/// A device whose tip moves, and whose motors push, more or less than the hand and the scene. What
/// is stiff by k in the scene is so by motion * force * k in the hand, which is what a servo's
/// limit of stability is about. Directions stay.
/// @throws InvalidArgument  if there is no device, or a scale is outside its range or not finite
[[nodiscard]] PBDSURG_API std::unique_ptr<Device> scaled(std::unique_ptr<Device> device,
                                                         const DeviceScale& scale);

/// A device in another frame, such as the rig's arm at the port of its instrument: the pose is
/// to_scene * pose * instrument.
/// @param to_scene    from the axes of the device to those of the scene
/// @param instrument  in what the device moves: tip at the origin, shaft along +z
/// @throws InvalidArgument  if there is no device, or one of the two is not rigid
[[nodiscard]] PBDSURG_API std::unique_ptr<Device> transformed(
    std::unique_ptr<Device> device, const Eigen::Isometry3f& to_scene,
    const Eigen::Isometry3f& instrument = Eigen::Isometry3f::Identity());

/// Which bit the first button of a handle has in DeviceState::buttons; those below are the arm's.
inline constexpr int kFirstHandleButton = 8;

/// A device with a handle on it: the jaw is the handle's, its wheel turns the instrument about its
/// shaft, its buttons join the device's. A lost handle leaves the device connected: the pose still
/// counts. Handle::poll() is called with each state.
/// @param handle  outlives the device, and is read by its thread
/// @throws InvalidArgument  if there is no device
[[nodiscard]] PBDSURG_API std::unique_ptr<Device> with_handle(std::unique_ptr<Device> device,
                                                              Handle& handle);

/// A device with pedals beside those that it has: each is down if either is. With two keyboards,
/// one for each pedal, this is done twice. They are up while the device is not connected.
/// PedalKeyboard::poll() is called with each state.
/// @param pedals  outlive the device, and are read by its thread
/// @throws InvalidArgument  if there is no device
[[nodiscard]] PBDSURG_API std::unique_ptr<Device> with_pedals(std::unique_ptr<Device> device,
                                                              PedalKeyboard& pedals);

}  // namespace pbdsurg
