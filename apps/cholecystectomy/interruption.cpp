// SPDX-License-Identifier: Apache-2.0
#include "interruption.h"

#include <csignal>
#include <initializer_list>

#include <unistd.h>

namespace cholecystectomy {
namespace {

volatile std::sig_atomic_t is_noted = 0;

extern "C" void end_program(int) {
  _exit(kInterruptedStatus);
}

extern "C" void note_signal(int) {
  if (is_noted != 0) {
    _exit(kInterruptedStatus);
  }
  is_noted = 1;
}

void handle(void (*handler)(int)) {
  for (const int signal : {SIGINT, SIGTERM}) {
    if (std::signal(signal, handler) == SIG_IGN) {
      std::signal(signal, SIG_IGN);
    }
  }
}

}  // namespace

void end_on_interrupt() {
  handle(end_program);
}

void note_interrupt() {
  handle(note_signal);
}

bool is_interrupted() noexcept {
  return is_noted != 0;
}

}  // namespace cholecystectomy
