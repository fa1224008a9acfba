// SPDX-License-Identifier: Apache-2.0
#include "apps/sound/openal_output.h"

#include <cstdlib>

#include <AL/alext.h>

#include "pbdsurg/base/error.h"

#include "apps/sound/tones.h"

namespace cholecystectomy {
namespace {

ALCdevice* open_default_device() {
  ALCdevice* const device = alcOpenDevice(nullptr);
  if (device == nullptr) {
    const char* const drivers = std::getenv("ALSOFT_DRIVERS");
    throw pbdsurg::BackendUnavailable(
        "no audio device; OpenAL could open none" +
        (drivers != nullptr ? " with ALSOFT_DRIVERS=" + std::string(drivers) : std::string()));
  }
  return device;
}

/// Binds a context to the calling thread: other users of OpenAL in this process have theirs.
bool bind(ALCcontext* context) {
  static const auto set_context = reinterpret_cast<PFNALCSETTHREADCONTEXTPROC>(
      alcGetProcAddress(nullptr, "alcSetThreadContext"));
  return set_context != nullptr && set_context(context) == ALC_TRUE;
}

std::string name_of(ALCdevice* device) {
  const ALCenum what = alcIsExtensionPresent(device, "ALC_ENUMERATE_ALL_EXT") == ALC_TRUE
                           ? ALC_ALL_DEVICES_SPECIFIER
                           : ALC_DEVICE_SPECIFIER;
  const ALCchar* const name = alcGetString(device, what);
  return name != nullptr && *name != '\0' ? name : "a device without a name";
}

void fill(ALuint buffer, const Samples& samples) {
  alBufferData(buffer, AL_FORMAT_MONO16, samples.data(),
               static_cast<ALsizei>(samples.size() * sizeof(samples[0])), kSampleRate);
}

/// Heard the same wherever the listener is.
ALuint make_source() {
  ALuint source = 0;
  alGenSources(1, &source);
  alSourcei(source, AL_SOURCE_RELATIVE, AL_TRUE);
  return source;
}

bool is_playing(ALuint source) {
  ALint state = AL_STOPPED;
  alGetSourcei(source, AL_SOURCE_STATE, &state);
  return state == AL_PLAYING;
}

}  // namespace

void OpenAlOutput::CloseDevice::operator()(ALCdevice* device) const {
  alcCloseDevice(device);
}

void OpenAlOutput::DestroyContext::operator()(ALCcontext* context) const {
  bind(nullptr);
  alcDestroyContext(context);
}

OpenAlOutput::OpenAlOutput() : OpenAlOutput(open_default_device(), nullptr) {}

OpenAlOutput::OpenAlOutput(ALCdevice* device, const ALCint* attributes)
    : device_(device), device_name_(name_of(device)) {
  make_context(attributes);
  make_sources();
}

OpenAlOutput::~OpenAlOutput() {
  for (const ToneSource& tone : tones_) {
    alDeleteSources(1, &tone.source);
    alDeleteBuffers(1, &tone.buffer);
  }
  alDeleteSources(static_cast<ALsizei>(voices_.size()), voices_.data());
  alDeleteBuffers(static_cast<ALsizei>(chimes_.size()), chimes_.data());
}

void OpenAlOutput::make_context(const ALCint* attributes) {
  context_.reset(alcCreateContext(device_.get(), attributes));
  if (context_ == nullptr || !bind(context_.get())) {
    throw pbdsurg::BackendUnavailable("the audio device '" + device_name_ +
                                      "' gives OpenAL no context");
  }
  if (alIsExtensionPresent("AL_SOFT_loop_points") != AL_TRUE) {
    throw pbdsurg::BackendUnavailable("this OpenAL has no AL_SOFT_loop_points; OpenAL Soft has");
  }
}

// What is made before a failure goes with the context and the device.
void OpenAlOutput::make_sources() {
  alGetError();  // forget
  tones_[0].tone = Tone::cut;
  tones_[1].tone = Tone::coagulation;
  for (ToneSource& tone : tones_) {
    const ToneSamples sound = make_tone(tone.tone);
    alGenBuffers(1, &tone.buffer);
    fill(tone.buffer, sound.samples);
    const std::array<ALint, 2> loop{static_cast<ALint>(sound.loop_begin),
                                    static_cast<ALint>(sound.loop_end)};
    alBufferiv(tone.buffer, AL_LOOP_POINTS_SOFT, loop.data());
    tone.source = make_source();
    alSourcei(tone.source, AL_BUFFER, static_cast<ALint>(tone.buffer));
  }
  alGenBuffers(static_cast<ALsizei>(chimes_.size()), chimes_.data());
  for (std::size_t i = 0; i < chimes_.size(); ++i) {
    fill(chimes_[i], make_chime(static_cast<Chime>(i)));
  }
  for (ALuint& voice : voices_) {
    voice = make_source();
  }
  if (alGetError() != AL_NO_ERROR) {
    throw pbdsurg::BackendUnavailable("OpenAL does not take the sounds for the audio device '" +
                                      device_name_ + "'");
  }
}

bool OpenAlOutput::is_connected() {
  ALCint is_connected = ALC_TRUE;  // for all that is known where the extension is missing
  if (alcIsExtensionPresent(device_.get(), "ALC_EXT_disconnect") == ALC_TRUE) {
    alcGetIntegerv(device_.get(), ALC_CONNECTED, 1, &is_connected);
  }
  return is_connected != ALC_FALSE;
}

void OpenAlOutput::set_volume(float volume) {
  alListenerf(AL_GAIN, volume);
}

bool OpenAlOutput::set_tone(Tone tone) {
  bool is_under_way = true;
  for (ToneSource& source : tones_) {
    if (source.is_held && source.tone != tone) {
      alSourcei(source.source, AL_LOOPING, AL_FALSE);  // on through the fall to the end
      source.is_held = false;
    } else if (!source.is_held && source.tone == tone) {
      if (is_playing(source.source)) {
        is_under_way = false;
        continue;
      }
      alSourcei(source.source, AL_LOOPING, AL_TRUE);
      alSourcePlay(source.source);
      source.is_held = true;
    }
  }
  return is_under_way;
}

void OpenAlOutput::play(Chime chime) {
  for (const ALuint voice : voices_) {
    if (!is_playing(voice)) {
      alSourcei(voice, AL_BUFFER, static_cast<ALint>(chimes_[static_cast<std::size_t>(chime)]));
      alSourcePlay(voice);
      return;
    }
  }
}

}  // namespace cholecystectomy
