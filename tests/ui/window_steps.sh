# shellcheck shell=bash disable=SC2154
# What the tests of a person at the window share: an own display, an own folder, waiting, failing. Sourced by them,
# behind `kerf=$1 window=$2`. Before it, if wanted: size (of display and window, 800x600).
# Exit code 77: xvfb-run or xdotool is missing.
for program in xvfb-run xdotool; do
  command -v $program >/dev/null || { printf '%s: %s is missing (Debian: xvfb, xdotool)\n' "$(basename "$0")" $program; exit 77; }
done
if [[ -z ${IN_XVFB:-} ]]; then
  # -r: a key that a slow machine leaves down for long is not typed twice.
  IN_XVFB=yes exec xvfb-run -a -s "-screen 0 ${size:-800x600}x24 -noreset -r" "$0" "$@"
fi

folder=$(mktemp -d)
log=$folder/log
cd "$folder"
pid=""
cleanup() {
  [[ -z $pid ]] || kill -9 "$pid" 2>/dev/null || true
  rm -rf "$folder"
}
trap cleanup EXIT
fail() {
  printf '%s: %s\n' "$(basename "$0")" "$1" >&2
  sed 's/^/  kerf-sim: /' "$log" >&2 || true
  exit 1
}
until_true() { # SECONDS WHAT COMMAND...: tries until the command is true
  local seconds=$1 what=$2
  shift 2
  for ((n = 0; n < 5 * seconds; n++)); do
    if "$@" >/dev/null 2>&1; then return 0; fi
    kill -0 "$pid" 2>/dev/null || fail "the window is gone before: $what"
    sleep 0.2
  done
  fail "not within $seconds s: $what"
}
start() { # OPTIONS...: the window, with data and settings in the folder; it asks for files itself, zenity or not
  [[ -e $folder/config/settings.toml ]] || { mkdir -p "$folder/config"; echo 'file_dialog = "own"' >"$folder/config/settings.toml"; }
  "$window" -v --data "$folder/data" --config "$folder/config" --size "${size:-800x600}" "$@" >"$log" 2>&1 &
  pid=$!
  until_true 60 'a window' xdotool search --name '.'
}
said() { grep -qE "^kerf-sim: (note|error): .*$1" "$log"; }
says() { # SECONDS WORDS: the window's notices hold these words, a regular expression
  until_true "$1" "it says \"$2\"" said "$2"
}
focus_once() { xdotool windowfocus "$(xdotool search --name "$1" | head -n 1)"; }
focus() { # NAME: there is no window manager that would; a window that is not yet mapped refuses it
  until_true 60 "focus on $1" focus_once "$1"
}
hold() { # X Y SECONDS: one press, held
  xdotool mousemove "$1" "$2" mousedown 1
  sleep "$3"
  xdotool mouseup 1
}
# CODE: the window ends by itself, with that exit code.
ends_with() {
  local code=0
  for ((n = 0; n < 300; n++)); do kill -0 "$pid" 2>/dev/null || break; sleep 0.2; done
  wait "$pid" || code=$?
  pid=""
  [[ $code == "$1" ]] || fail "exit code $code, not $1"
}
whole() { [[ -s $1 ]] && "$kerf" check "$1"; }
# NAME: the display as a picture in the folder KERF_TEST_PICTURES, for people who look at what a test does.
shot() { [[ -z ${KERF_TEST_PICTURES:-} ]] || import -window root "$KERF_TEST_PICTURES/$1.png"; }
# TEXT: a command with its parameters, through the palette. What comes from keyboard and mouse waits in its order until
# the window takes it: a slow frame makes nothing of it go elsewhere. What a test looks at then, it waits for.
command_line() {
  xdotool key ctrl+shift+p
  sleep 0.7
  xdotool type --delay 40 "$1"
  sleep 0.5
  xdotool key Return
  sleep 0.7
}
# TEXT: the same, of what may be refused as yet. Then the palette is put away, to be asked again.
try_command() {
  command_line "$1"
  xdotool key Escape
}
# SECONDS WHAT COMMAND... -- STEP...: does the step again and again until the command is true. A step is given so long
# before the next: one that is late must not be done twice.
until_true_by() {
  local seconds=$1 what=$2 condition=() try n
  shift 2
  while [[ $1 != -- ]]; do
    condition+=("$1")
    shift
  done
  shift
  for ((try = 0; try < 10; try++)); do
    "$@"
    for ((n = 0; n < 5 * seconds; n++)); do
      if "${condition[@]}" >/dev/null 2>&1; then return 0; fi
      kill -0 "$pid" 2>/dev/null || fail "the window is gone before: $what"
      sleep 0.2
    done
  done
  fail "not in 10 times $seconds s: $what"
}
