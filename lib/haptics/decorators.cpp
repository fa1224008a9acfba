// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/haptics/decorators.h"

#include <cmath>
#include <string>
#include <utility>

#include "lib/haptics/check_device.h"

namespace pbdsurg {
namespace {

class ScaledDevice final : public Device {
 public:
  ScaledDevice(std::unique_ptr<Device> device, const DeviceScale& scale)
      : device_(std::move(device)), scale_(scale) {}

  [[nodiscard]] std::string name() const override { return device_->name(); }
  [[nodiscard]] DeviceState state() noexcept override {
    DeviceState state = device_->state();
    auto tip = state.pose.translation();
    tip = scale_.centre + scale_.motion * (tip - scale_.centre);
    return state;
  }
  void set_force(const Eigen::Vector3f& force) noexcept override {
    device_->set_force(scale_.force * force);
  }

 private:
  std::unique_ptr<Device> device_;
  DeviceScale scale_;
};

class TransformedDevice final : public Device {
 public:
  TransformedDevice(std::unique_ptr<Device> device, const Eigen::Isometry3f& to_scene,
                    const Eigen::Isometry3f& instrument)
      : device_(std::move(device)), to_scene_(to_scene), instrument_(instrument) {}

  [[nodiscard]] std::string name() const override { return device_->name(); }
  [[nodiscard]] DeviceState state() noexcept override {
    DeviceState state = device_->state();
    state.pose = to_scene_ * state.pose * instrument_;
    return state;
  }
  void set_force(const Eigen::Vector3f& force) noexcept override {
    device_->set_force(to_scene_.linear().transpose() * force);
  }

 private:
  std::unique_ptr<Device> device_;
  Eigen::Isometry3f to_scene_, instrument_;
};

class DeviceWithHandle final : public Device {
 public:
  DeviceWithHandle(std::unique_ptr<Device> device, Handle& handle)
      : device_(std::move(device)), handle_(handle) {}

  [[nodiscard]] std::string name() const override { return device_->name(); }
  [[nodiscard]] DeviceState state() noexcept override {
    DeviceState state = device_->state();
    const HandleState& handle = handle_.poll();
    state.jaw = handle.jaw;
    state.pose.rotate(Eigen::AngleAxisf(handle.roll, Eigen::Vector3f::UnitZ()));
    state.buttons |= handle.buttons << kFirstHandleButton;
    return state;
  }
  void set_force(const Eigen::Vector3f& force) noexcept override { device_->set_force(force); }

 private:
  std::unique_ptr<Device> device_;
  Handle& handle_;
};

class DeviceWithPedals final : public Device {
 public:
  DeviceWithPedals(std::unique_ptr<Device> device, PedalKeyboard& pedals)
      : device_(std::move(device)), pedals_(pedals) {}

  [[nodiscard]] std::string name() const override { return device_->name(); }
  [[nodiscard]] DeviceState state() noexcept override {
    DeviceState state = device_->state();
    pedals_.poll();
    const Pedals& pedals = pedals_.event().pedals;
    state.pedals.cut = state.is_connected && (state.pedals.cut || pedals.cut);
    state.pedals.coagulation =
        state.is_connected && (state.pedals.coagulation || pedals.coagulation);
    return state;
  }
  void set_force(const Eigen::Vector3f& force) noexcept override { device_->set_force(force); }

 private:
  std::unique_ptr<Device> device_;
  PedalKeyboard& pedals_;
};

void check_scale(float scale, bool is_in_range, const std::string& what, const std::string& rule) {
  if (!is_in_range || !std::isfinite(scale)) {
    throw InvalidArgument(what + " is " + std::to_string(scale) + "; it must be finite and " +
                          rule);
  }
}

void check_rigid(const Eigen::Isometry3f& transform, const std::string& what) {
  if (!transform.matrix().allFinite() || !is_rotation(transform.linear())) {
    throw InvalidArgument(what +
                          " of a device must be rigid and finite; its axes are not those of " +
                          "a rotation, to 1e-3, or it is not finite");
  }
}

}  // namespace

std::unique_ptr<Device> scaled(std::unique_ptr<Device> device, const DeviceScale& scale) {
  check_device(device.get());
  check_scale(scale.motion, scale.motion > 0, "the motion scale of a device", "above 0");
  check_scale(scale.force, scale.force >= 0, "the force scale of a device", "0 or more");
  if (!scale.centre.allFinite()) {
    throw InvalidArgument("the centre of a device's scale is not finite; it must be");
  }
  return std::make_unique<ScaledDevice>(std::move(device), scale);
}

std::unique_ptr<Device> transformed(std::unique_ptr<Device> device,
                                    const Eigen::Isometry3f& to_scene,
                                    const Eigen::Isometry3f& instrument) {
  check_device(device.get());
  check_rigid(to_scene, "the transform to the scene");
  check_rigid(instrument, "the instrument");
  return std::make_unique<TransformedDevice>(std::move(device), to_scene, instrument);
}

std::unique_ptr<Device> with_handle(std::unique_ptr<Device> device, Handle& handle) {
  check_device(device.get());
  return std::make_unique<DeviceWithHandle>(std::move(device), handle);
}

std::unique_ptr<Device> with_pedals(std::unique_ptr<Device> device, PedalKeyboard& pedals) {
  check_device(device.get());
  return std::make_unique<DeviceWithPedals>(std::move(device), pedals);
}

}  // namespace pbdsurg
