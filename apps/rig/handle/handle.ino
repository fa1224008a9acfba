// SPDX-License-Identifier: Apache-2.0
// An instrument's handle: a sensor of the jaw, one of the wheel, two buttons. For Arduinos of 10 bits.
// Wiring and the lines that it sends: docs/rig/handles.md.

const uint8_t kJawPin = A0;             // 0 V to the supply's over the handle's way
const uint8_t kRollPin = A1;            // 0 V to the supply's over one turn
const uint8_t kButtonPins[2] = {2, 3};  // to ground while pressed
const uint8_t kPeriod = 10;             // ms between lines
const uint8_t kReadings = 16;           // of the jaw, for one line: 2 ms

uint16_t sequence = 0;
uint32_t next_line = 0;                 // ms

void setup() {
  Serial.begin(115200);
  for (uint8_t i = 0; i < 2; ++i) {
    pinMode(kButtonPins[i], INPUT_PULLUP);
  }
}

char* put_field(char* at, uint16_t value, int8_t digits) {
  *at++ = ' ';
  for (int8_t shift = 4 * digits - 4; shift >= 0; shift -= 4) {
    *at++ = "0123456789ABCDEF"[(value >> shift) & 15];
  }
  return at;
}

uint16_t checksum(const char* at, const char* end) {  // CRC-16/CCITT-FALSE
  uint16_t value = 0xFFFF;
  while (at < end) {
    value ^= (uint16_t)(*at++ << 8);
    for (uint8_t bit = 0; bit < 8; ++bit) {
      value = (uint16_t)((value << 1) ^ (value & 0x8000 ? 0x1021 : 0));
    }
  }
  return value;
}

void loop() {
  if ((int32_t)(millis() - next_line) < 0) return;
  next_line = millis() + kPeriod;
  uint32_t jaw = 0;
  for (uint8_t i = 0; i < kReadings; ++i) {
    jaw += analogRead(kJawPin);  // 10 bits; the sum has 14
  }
  uint8_t buttons = 0;
  for (uint8_t i = 0; i < 2; ++i) {
    buttons |= (digitalRead(kButtonPins[i]) == LOW) << i;
  }
  char line[26] = {'P', '1'};
  char* end = put_field(put_field(line + 2, sequence++, 4), jaw << 2, 4);
  end = put_field(end, analogRead(kRollPin) << 6, 4);  // no mean: a turn wraps
  end = put_field(end, buttons, 2);
  end = put_field(end, checksum(line, end), 4);
  *end = '\n';
  if (Serial.availableForWrite() >= 26) {  // a line that waits is worse than none
    Serial.write(line, 26);
  }
}
