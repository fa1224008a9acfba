// SPDX-License-Identifier: Apache-2.0
#include "apps/hdapi_emulator/emulator.h"

#include "pbdsurg/base/error.h"

#include "apps/hdapi_emulator/engine.h"

namespace hdapi_emulator {

const char* name_of(Fault fault) noexcept {
  switch (fault) {
    case Fault::lost_communication:
      return "lost communication";
    case Fault::dropped_tick:
      return "dropped tick";
    case Fault::late_tick:
      return "late tick";
    case Fault::warm_motors:
      return "warm motors";
    case Fault::stuck_calibration:
      return "stuck calibration";
    case Fault::wrong_handle:
      return "wrong handle";
    case Fault::force_error:
      return "force error";
    case Fault::unplugged:
      return "unplugged";
    case Fault::simulation_nan:
      return "NaN from the simulation";
    case Fault::stale_packets:
      return "stale packets";
    case Fault::clock_jump:
      return "clock jump";
    case Fault::swapped_devices:
      return "swapped devices";
  }
  return "";
}

Emulator::Emulator(const EmulatorOptions& options) {
  if (options.devices.empty()) {
    throw pbdsurg::InvalidArgument("an emulator has 0 devices; it needs at least one");
  }
  engine_ = std::make_unique<Engine>(options);
}

Emulator::~Emulator() = default;

pbdsurg::Clock& Emulator::clock() noexcept {
  return engine_->clock();
}
double Emulator::scheduler_time() const {
  return engine_->time();
}
void Emulator::step(int ticks) {
  engine_->step(ticks);
}
void Emulator::inject(const FaultPlan& plan) {
  engine_->inject(plan);
}
bool Emulator::is_active(Fault fault, int device) const {
  return engine_->is_active(fault, device);
}
std::vector<ForceRecord> Emulator::forces(int device) const {
  return engine_->forces(device);
}
Eigen::Vector3d Emulator::position(int device) const {
  return engine_->position(device);
}
int Emulator::open_device_count() const {
  return engine_->open_device_count();
}
int Emulator::callback_count() const {
  return engine_->callback_count();
}
int Emulator::error_count() const {
  return engine_->error_count();
}
bool Emulator::is_running() const {
  return engine_->is_running();
}
std::vector<std::string> Emulator::calls() const {
  return engine_->calls();
}

}  // namespace hdapi_emulator
