// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// An EMULATOR of HDAPI, the device layer of OpenHaptics: the part of its public names that
/// apps/hdapi uses, with the behaviour that its documentation gives them. Written from a
/// description of that interface, without a look at the vendor's headers. Programs that are
/// compiled with it are to be linked with the emulator: the names are HDAPI's, the values ours.
///
/// apps/hdapi_emulator/emulator.h plugs in devices, moves hands and breaks things.

#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

#if defined(_WIN32)
#define HDCALLBACK __stdcall
#else
#define HDCALLBACK
#endif

typedef unsigned int HHD;  ///< a device that was opened
typedef unsigned int HDenum;
typedef int HDint;
typedef unsigned int HDuint;
typedef unsigned long HDulong;
typedef unsigned short HDushort;
typedef unsigned char HDboolean;
typedef double HDdouble;
typedef const char* HDstring;
typedef unsigned int HDerror;
typedef unsigned long HDSchedulerHandle;
typedef unsigned int HDCallbackCode;
typedef HDCallbackCode(HDCALLBACK* HDSchedulerCallback)(void* data);

/// One error of those that hdGetError() takes off the stack.
typedef struct {
  HDerror errorCode;
  int internalErrorCode;
  HHD hHD;
} HDErrorInfo;

#define HD_DEVICE_ERROR(info) ((info).errorCode != HD_SUCCESS)
#define HD_DEFAULT_DEVICE NULL
#define HD_INVALID_HANDLE ((HHD)0xFFFFFFFFu)
#define HD_TRUE ((HDboolean)1)
#define HD_FALSE ((HDboolean)0)

enum {
  HD_SUCCESS = 0,

  // of the call
  HD_INVALID_ENUM = 0x1001,
  HD_INVALID_VALUE,
  HD_INVALID_OPERATION,
  HD_INVALID_INPUT_TYPE,
  HD_BAD_HANDLE,
  HD_INVALID_PRIORITY,
  HD_SCHEDULER_FULL,
  HD_ILLEGAL_BEGIN,
  HD_ILLEGAL_END,
  HD_FRAME_ERROR,

  // of the force
  HD_WARM_MOTORS = 0x1101,
  HD_EXCEEDED_MAX_FORCE,
  HD_EXCEEDED_MAX_FORCE_IMPULSE,
  HD_EXCEEDED_MAX_VELOCITY,
  HD_FORCE_ERROR,

  // of the device or the scheduler
  HD_DEVICE_FAULT = 0x1201,
  HD_DEVICE_ALREADY_INITIATED,
  HD_COMM_ERROR,
  HD_COMM_CONFIG_ERROR,
  HD_TIMER_ERROR,
  HD_INVALID_LICENSE
};

enum {
  HD_CURRENT_POSITION = 0x2001,  ///< 3 double, mm
  HD_CURRENT_TRANSFORM,          ///< 16 double, by columns, mm
  HD_CURRENT_VELOCITY,           ///< 3 double, mm/s
  HD_CURRENT_ANGULAR_VELOCITY,   ///< 3 double, rad/s
  HD_CURRENT_JOINT_ANGLES,       ///< 3 double, rad
  HD_CURRENT_GIMBAL_ANGLES,      ///< 3 double, rad
  HD_CURRENT_BUTTONS,            ///< 1 int, a mask of HD_DEVICE_BUTTON_...
  HD_CURRENT_INKWELL_SWITCH,     ///< 1 boolean
  HD_CURRENT_SAFETY_SWITCH,      ///< 1 boolean
  HD_CURRENT_FORCE,              ///< 3 double, N; can be set

  HD_NOMINAL_MAX_FORCE = 0x2101,    ///< 1 double, N
  HD_NOMINAL_MAX_CONTINUOUS_FORCE,  ///< 1 double, N
  HD_NOMINAL_MAX_STIFFNESS,         ///< 1 double
  HD_NOMINAL_MAX_DAMPING,           ///< 1 double
  HD_USABLE_WORKSPACE_DIMENSIONS,   ///< 6 double, mm: least x y z, greatest x y z
  HD_MAX_WORKSPACE_DIMENSIONS,      ///< 6 double, mm: likewise
  HD_MOTOR_TEMPERATURE,             ///< 3 double, 0 cold to 1 warm
  HD_CALIBRATION_STYLE,             ///< 1 int, a mask of HD_CALIBRATION_...

  HD_UPDATE_RATE = 0x2201,          ///< 1 int, Hz
  HD_INSTANTANEOUS_UPDATE_RATE,     ///< 1 int, Hz
  HD_FORCE_RAMPING_RATE,            ///< 1 double, N/s; can be set
  HD_SOFTWARE_FORCE_IMPULSE_LIMIT,  ///< 1 double, N/ms; can be set; also a capability
  HD_SOFTWARE_VELOCITY_LIMIT,       ///< 1 double, mm/s; can be set; also a capability

  HD_DEVICE_MODEL_TYPE = 0x2301,  ///< string
  HD_DEVICE_SERIAL_NUMBER,        ///< string
  HD_DEVICE_DRIVER_VERSION,       ///< string
  HD_VERSION                      ///< string
};

// Capabilities
enum {
  HD_FORCE_OUTPUT = 0x3001,
  HD_MAX_FORCE_CLAMPING,  ///< scales what is too much instead of refusing it
  HD_FORCE_RAMPING,       ///< after the start and after errors
  HD_SOFTWARE_FORCE_LIMIT,
  HD_ONE_FRAME_LIMIT
};

enum {
  HD_DEVICE_BUTTON_1 = 1 << 0,
  HD_DEVICE_BUTTON_2 = 1 << 1,
  HD_DEVICE_BUTTON_3 = 1 << 2,
  HD_DEVICE_BUTTON_4 = 1 << 3
};

enum {
  HD_CALIBRATION_ENCODER_RESET = 1 << 0,
  HD_CALIBRATION_AUTO = 1 << 1,
  HD_CALIBRATION_INKWELL = 1 << 2
};

enum { HD_CALIBRATION_OK = 0x3101, HD_CALIBRATION_NEEDS_UPDATE, HD_CALIBRATION_NEEDS_MANUAL_INPUT };

enum { HD_CALLBACK_DONE = 0x3201, HD_CALLBACK_CONTINUE };
enum { HD_WAIT_CHECK_STATUS = 0x3301, HD_WAIT_INFINITE };

#define HD_MIN_SCHEDULER_PRIORITY ((HDushort)0)
#define HD_DEFAULT_SCHEDULER_PRIORITY ((HDushort)32767)
#define HD_MAX_SCHEDULER_PRIORITY ((HDushort)65534)

// Devices. All that names none is about the current one.
HHD hdInitDevice(HDstring name);
void hdDisableDevice(HHD device);
void hdMakeCurrentDevice(HHD device);
HHD hdGetCurrentDevice(void);
void hdBeginFrame(HHD device);
void hdEndFrame(HHD device);
void hdEnable(HDenum capability);
void hdDisable(HDenum capability);
HDboolean hdIsEnabled(HDenum capability);
void hdGetBooleanv(HDenum parameter, HDboolean* values);
void hdGetIntegerv(HDenum parameter, HDint* values);
void hdGetDoublev(HDenum parameter, HDdouble* values);
HDstring hdGetString(HDenum parameter);
void hdSetDoublev(HDenum parameter, const HDdouble* values);
HDenum hdCheckCalibration(void);
void hdUpdateCalibration(HDenum style);

// Errors, the newest first
HDErrorInfo hdGetError(void);
HDstring hdGetErrorString(HDerror error);

// The scheduler, one for all devices
HDSchedulerHandle hdScheduleAsynchronous(HDSchedulerCallback callback, void* data,
                                         HDushort priority);
void hdScheduleSynchronous(HDSchedulerCallback callback, void* data, HDushort priority);
void hdUnschedule(HDSchedulerHandle handle);
HDboolean hdWaitForCompletion(HDSchedulerHandle handle, HDenum wait);
void hdStartScheduler(void);
void hdStopScheduler(void);
void hdSetSchedulerRate(HDulong rate);
HDdouble hdGetSchedulerTimeStamp(void);

#ifdef __cplusplus
}
#endif
