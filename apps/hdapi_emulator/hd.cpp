// SPDX-License-Identifier: Apache-2.0
// HDAPI's names for what the engine does.
#include <HD/hd.h>

#include "apps/hdapi_emulator/engine.h"

using hdapi_emulator::Engine;

extern "C" {

HHD hdInitDevice(HDstring name) {
  return Engine::current().init_device(name);
}
void hdDisableDevice(HHD device) {
  Engine::current().disable_device(device);
}
void hdMakeCurrentDevice(HHD device) {
  Engine::current().make_current(device);
}
HHD hdGetCurrentDevice() {
  return Engine::current().current_device();
}
void hdBeginFrame(HHD device) {
  Engine::current().begin_frame(device);
}
void hdEndFrame(HHD device) {
  Engine::current().end_frame(device);
}
void hdEnable(HDenum capability) {
  Engine::current().enable(capability, true);
}
void hdDisable(HDenum capability) {
  Engine::current().enable(capability, false);
}
HDboolean hdIsEnabled(HDenum capability) {
  return Engine::current().is_enabled(capability) ? HD_TRUE : HD_FALSE;
}
void hdGetBooleanv(HDenum parameter, HDboolean* values) {
  Engine::current().get(parameter, values);
}
void hdGetIntegerv(HDenum parameter, HDint* values) {
  Engine::current().get(parameter, values);
}
void hdGetDoublev(HDenum parameter, HDdouble* values) {
  Engine::current().get(parameter, values);
}
HDstring hdGetString(HDenum parameter) {
  return Engine::current().get_string(parameter);
}
void hdSetDoublev(HDenum parameter, const HDdouble* values) {
  Engine::current().set_doubles(parameter, values);
}
HDenum hdCheckCalibration() {
  return Engine::current().check_calibration();
}
void hdUpdateCalibration(HDenum style) {
  Engine::current().update_calibration(style);
}

HDErrorInfo hdGetError() {
  return Engine::current().take_error();
}
HDstring hdGetErrorString(HDerror error) {
  switch (error) {
    case HD_SUCCESS:
      return "no error";
    case HD_INVALID_ENUM:
      return "no such name for this call";
    case HD_INVALID_VALUE:
      return "a value out of range";
    case HD_INVALID_OPERATION:
      return "not possible now";
    case HD_INVALID_INPUT_TYPE:
      return "the parameter has another type";
    case HD_BAD_HANDLE:
      return "no device has this handle";
    case HD_INVALID_PRIORITY:
      return "a priority out of range";
    case HD_SCHEDULER_FULL:
      return "too many callbacks";
    case HD_ILLEGAL_BEGIN:
      return "a second frame in one tick";
    case HD_ILLEGAL_END:
      return "the end of a frame that did not begin";
    case HD_FRAME_ERROR:
      return "a frame was left open";
    case HD_WARM_MOTORS:
      return "the motors are too warm";
    case HD_EXCEEDED_MAX_FORCE:
      return "more force than the device has";
    case HD_EXCEEDED_MAX_FORCE_IMPULSE:
      return "the force changed too fast";
    case HD_EXCEEDED_MAX_VELOCITY:
      return "the stylus moved too fast";
    case HD_FORCE_ERROR:
      return "the motors failed";
    case HD_DEVICE_FAULT:
      return "no such device, or it failed";
    case HD_DEVICE_ALREADY_INITIATED:
      return "the device is open already";
    case HD_COMM_ERROR:
      return "the device does not answer";
    case HD_COMM_CONFIG_ERROR:
      return "the port is not set up";
    case HD_TIMER_ERROR:
      return "the scheduler cannot run";
    case HD_INVALID_LICENSE:
      return "no licence";
    default:
      return "no error has this number";
  }
}

HDSchedulerHandle hdScheduleAsynchronous(HDSchedulerCallback callback, void* data,
                                         HDushort priority) {
  return Engine::current().schedule(callback, data, priority);
}
void hdScheduleSynchronous(HDSchedulerCallback callback, void* data, HDushort priority) {
  Engine::current().run_in_tick(callback, data, priority);
}
void hdUnschedule(HDSchedulerHandle handle) {
  Engine::current().unschedule(handle);
}
HDboolean hdWaitForCompletion(HDSchedulerHandle handle, HDenum wait) {
  return Engine::current().wait_for(handle, wait) ? HD_TRUE : HD_FALSE;
}
void hdStartScheduler() {
  Engine::current().start();
}
void hdStopScheduler() {
  Engine::current().stop();
}
void hdSetSchedulerRate(HDulong rate) {
  Engine::current().set_rate(rate);
}
HDdouble hdGetSchedulerTimeStamp() {
  return Engine::current().time_in_tick();
}

}  // extern "C"
