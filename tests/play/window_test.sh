#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Usage: window_test.sh PROGRAM FOLDER CASE
#
# Plays the demo's window on a display without a screen, by the events of a mouse and a keyboard. Cases:
#
#   play      grasps, retracts, burns and takes back, is resized and minimised, loses the keyboard while
#             a pedal is down, which ends the current, makes its window anew; screenshots show it, and it
#             closes clean
#   rig       emulated arms grasp and burn, one of them is unplugged; the operation goes on until a signal
#   memory    shows MANY pictures, else 1000; memory does not grow
#   refusals  no display, settings that cannot be read, an executor or a sound card that there is not: one
#             sentence each
#
# Exits with 77, which ctest counts as skipped, where Xvfb or xdotool is missing.
set -euo pipefail

program=$1
folder=$2
case=$3
MANY=${MANY:-1000}
rm -rf "$folder"
mkdir -p "$folder"
export XDG_CONFIG_HOME="$folder/config" ALSOFT_DRIVERS=null
unset WAYLAND_DISPLAY

fail() {
  echo "window_test: $*" >&2
  [[ ! -r $folder/log ]] || cat "$folder/log" >&2
  exit 1
}

# value NAME: of a line of what the program said at its end
value() { sed -n "s/^$1 //p" "$folder/log"; }

# shoot: takes a screenshot, and sets time and energy of that moment
shots=0
shoot() {
  shots=$((shots + 1))
  local shot=""
  shot=$(printf 'screenshot_%03d.png' "$shots")
  xdotool key F12
  for _ in $(seq 300); do
    read -r time energy < <(sed -n "s/^$shot simulated_s \([^ ]*\) energy_j \(.*\)/\1 \2/p" "$folder/log") && return
    kill -0 "$game" || fail "it ended early"
    sleep 0.1
  done
  fail "no $shot within 30 s"
}

# holds EXPRESSION: of awk
holds() { awk "BEGIN { exit !($1) }"; }

if [[ $case == refusals ]]; then
  status=0
  env -u DISPLAY "$program" --out "$folder" >"$folder/log" 2>&1 || status=$?
  [[ $status == 2 ]] || fail "without a display it ended with $status"
  grep -q 'cholecystectomy: no window can be opened .*--headless' "$folder/log" || fail "no advice without a display"
fi

if ! { command -v Xvfb && command -v xdotool; } >/dev/null; then
  echo "skipped: needs Xvfb and xdotool"
  exit 77
fi
# Without -noreset the server starts anew when its last client leaves, which each xdotool may be, and
# refuses whoever connects meanwhile.
Xvfb -displayfd 3 -screen 0 1024x768x24 -nolisten tcp -noreset >"$folder/xvfb.log" 2>&1 3>"$folder/display" &
xvfb=$!
trap 'kill $xvfb 2>/dev/null || true' EXIT
for _ in $(seq 100); do
  [[ -s $folder/display ]] && break
  sleep 0.1
done
[[ -s $folder/display ]] || { echo "skipped: Xvfb did not start"; exit 77; }
DISPLAY=":$(<"$folder/display")"
export DISPLAY

settings() {
  mkdir -p "$folder/config/pbdsurg"
  printf '{"width": %d, "height": %d, "detail": "low"}\n' "$1" "$2" >"$folder/config/pbdsurg/cholecystectomy.json"
}

# begin ARGUMENTS...: starts the program and waits until its scene plays
begin() {
  "$program" --out "$folder/out" "$@" >"$folder/log" 2>&1 &
  game=$!
  window=""
  for _ in $(seq 2400); do
    kill -0 "$game" 2>/dev/null || fail "it ended early"
    window=$(xdotool search --name '^Laparoscopic' 2>/dev/null | head -n 1 || true)
    [[ -n $window ]] && grep -q '^playing' "$folder/log" && return
    sleep 0.1
  done
  fail "no scene within minutes"
}

# finish [STATUS]: waits for the end with a status, else 0
finish() {
  local status=0
  wait "$game" || status=$?
  ((status == ${1:-0})) || fail "it ended with $status"
}

# pause for what a slow picture takes in
rest() { sleep "${PAUSE:-0.4}"; }

drag() {  # DX DY [STEPS]: with the left button, from the middle of the picture
  xdotool mousemove --window "$window" "$middle_x" "$middle_y" mousedown 1
  rest
  for i in 1 2 3 4; do
    xdotool mousemove --window "$window" $((middle_x + $1 * i / 4)) $((middle_y + $2 * i / 4))
    rest
  done
  xdotool mouseup 1
  rest
}

advance() {  # NOTCHES: of the wheel
  for _ in $(seq "$1"); do
    xdotool click 4
    sleep 0.05
  done
  rest
}

case $case in
  play)
    width=${WIDTH:-640} height=${HEIGHT:-480}
    settings "$width" "$height"
    middle_x=$((width / 2)) middle_y=$((height / 2))
    begin
    xdotool mousemove --window "$window" "$middle_x" "$middle_y"
    xdotool key Return
    rest
    # the grasper over the gallbladder, then into the picture until it touches
    drag $((width / 16)) $((-height / 10))
    advance 16
    xdotool key g
    rest
    drag $((-width / 20)) $((height / 20))
    # the hook over the fat, likewise
    xdotool key Tab
    drag $((-width / 45)) $((-height / 7))
    advance 28
    rest
    xdotool keydown c
    sleep "${BURN:-3}"
    xdotool keyup c
    rest
    xdotool key z
    rest
    shoot
    xdotool windowsize "$window" $((width - 40)) $((height - 30))
    rest
    xdotool key F9
    sleep 2
    window=$(xdotool search --name '^Laparoscopic' | head -n 1)
    xdotool mousemove --window "$window" "$middle_x" "$middle_y"
    # away and back
    shoot
    before=$time
    xdotool windowunmap "$window"
    sleep 1
    xdotool windowmap "$window"
    rest
    xdotool windowfocus "$window"
    rest
    shoot
    holds "$time > $before + 0.3" || fail "the scene stood still while its window was away"
    # the keyboard goes elsewhere while a pedal is down
    xdotool keydown v
    rest
    shoot
    before=$energy before_time=$time
    sleep "${BURN:-3}"
    shoot
    holds "$energy > $before + 0.1" || fail "a pedal that is held spent $before, then $energy J"
    power=$(awk "BEGIN { print ($energy - $before) / ($time - $before_time) }")
    before=$energy before_time=$time
    xdotool windowfocus "$(xdotool search --maxdepth 0 --name '.*' 2>/dev/null | head -n 1)"
    sleep "${BURN:-3}"
    xdotool keyup v  # which nobody hears
    xdotool windowfocus "$window"
    rest
    shoot
    # what passes until the window knows is a share of the time
    holds "$energy - $before < 0.4 * $power * ($time - $before_time)" ||
      fail "without the keyboard the current went on: $before, then $energy J"
    before=$energy
    rest
    shoot
    holds "$energy == $before" || fail "with all keys up it spent $before, then $energy J"
    xdotool key f
    rest
    xdotool key Escape
    finish
    grep -q '"follows_tips": true' "$folder/config/pbdsurg/cholecystectomy.json" || fail "what F asks for is not kept"
    holds "$(value pictures_drawn) > 20" || fail "only $(value pictures_drawn) pictures"
    holds "$(value grasped) > 0" || fail "nothing was grasped"
    holds "$(value energy_j) > 1" || fail "nothing was burnt"
    holds "$(value undone) > 0" || fail "no edit was taken back"
    holds "$(value windows) == 2" || fail "the window was not made anew"
    for shot in "$folder"/out/screenshot_*.png; do
      size=$(stat -c %s "$shot")
      # a picture of one colour takes a few thousand bytes
      holds "$size > $((width * height / 20))" || fail "$shot has $size bytes"
    done
    ;;
  rig)
    settings 320 240
    cat >"$folder/rig.json" <<'END'
{"emulated": true, "left": {"device": "arm", "name": "A"}, "right": {"device": "arm", "name": "B"},
 "faults": [{"fault": "unplugged", "hand": "left", "begin_s": 10}]}
END
    begin --devices "$folder/rig.json"
    xdotool key Return
    energy=0
    until holds "$energy > 1"; do
      rest
      shoot
    done
    for _ in $(seq 1200); do
      grep -q '^The left arm is lost' "$folder/log" && break
      sleep 0.1
    done
    grep -q '^The left arm is lost' "$folder/log" || fail "nothing was said of the arm that was unplugged"
    shoot
    before=$time
    rest
    shoot
    holds "$time > $before" || fail "the scene stood still after the arm was lost"
    kill -TERM "$game"  # Ctrl-C is switched off for what a script starts with &
    finish 130
    holds "$(value grasped) > 0" || fail "nothing was grasped"
    for name in hand_at_step hand_at_packet hand_at_servo_left hand_at_servo_right state_at_picture; do
      grep -q "^age_ms $name median" "$folder/log" || fail "no age of $name"
    done
    ;;
  memory)
    settings "${WIDTH:-400}" "${HEIGHT:-300}"
    begin --pictures "$MANY"
    finish
    # allocators settle for a while: half of the pictures are left out
    ((MANY < 1000)) && { echo "too few pictures to judge memory"; exit 77; }
    holds "$(value memory_growth_mib) < 2" || fail "memory grew by $(value memory_growth_mib) MiB"
    ;;
  refusals)
    settings 640 480
    echo '{"volume": "loud"}' >"$folder/config/pbdsurg/cholecystectomy.json"
    begin --pictures 3 --detail low
    finish
    grep -q 'volume must be' "$folder/log" || fail "bad settings were not named"
    status=0
    "$program" --executor nobody --pictures 3 --detail low >"$folder/log" 2>&1 || status=$?
    ((status == 2)) || fail "an executor that there is not ended with $status"
    grep -q 'cholecystectomy: .*nobody' "$folder/log" || fail "the executor was not named"
    if ! compgen -G '/dev/snd/controlC*' >/dev/null; then
      env -u ALSOFT_DRIVERS "$program" --pictures 3 --detail low >"$folder/log" 2>&1 || fail "it ended with $?"
      [[ $(grep -cE '^(no )?sound: ' "$folder/log") == 1 ]] || fail "no sentence about sound"
      ! grep -q ALSA "$folder/log" || fail "ALSA tells what it lacks"
    fi
    ;;
  *) fail "no case $case" ;;
esac
echo "ok"
