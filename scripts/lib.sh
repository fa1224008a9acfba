# SPDX-License-Identifier: Apache-2.0
# Sourced by the other scripts: where the repository is, how to speak, how to build a preset.
# shellcheck shell=bash

root="$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)"

say() { printf '== %s\n' "$*"; }

fail() {
  printf '%s: error: %s\n' "$(basename "$0")" "$*" >&2
  exit 1
}

# Prints the comment at the head of the script that called it.
usage() { sed -n '2,/^[^#]/{/^# SPDX/d;s/^# \{0,1\}//p}' "$0"; }

# Value of an option that needs one: value_of OPTION "$@" with the option as first of the rest.
value_of() {
  [[ $# -ge 3 && -n "$3" ]] || fail "$1 needs a value; see --help"
  printf '%s\n' "$3"
}

# Bytes that this process may still use: the machine's, or its container's where that is less.
available_memory() {
  local bytes limit used
  bytes=$(($(awk '/^MemAvailable:/ {print $2}' /proc/meminfo) * 1024))
  if [[ -r /sys/fs/cgroup/memory.max && -r /sys/fs/cgroup/memory.current ]]; then
    limit=$(</sys/fs/cgroup/memory.max)
    used=$(</sys/fs/cgroup/memory.current)
    if [[ $limit != max ]] && ((limit - used < bytes)); then
      bytes=$((limit - used))
    fi
  fi
  printf '%s\n' "$bytes"
}

# How many compilers may run at once: one a processor, 1.5 GB each, at least one.
build_jobs() {
  local processors by_memory
  processors=$(nproc)
  by_memory=$(($(available_memory) / 1500000000))
  ((by_memory < 1)) && by_memory=1
  printf '%s\n' "$((by_memory < processors ? by_memory : processors))"
}

# Installs what is missing, unless PBDSURG_SKIP_SETUP=1 says that everything is there.
ensure_setup() {
  if [[ ${PBDSURG_SKIP_SETUP:-0} != 1 ]]; then
    "$root/scripts/setup"
  fi
}

# unpack_packages DIR: what is in its .deb files can be built and run with, without installing it.
unpack_packages() {
  local prefix="$root/build/packages" package link target multiarch
  compgen -G "$1/*.deb" >/dev/null || fail "no .deb file in $1"
  rm -rf "$prefix"
  mkdir -p "$prefix"
  for package in "$1"/*.deb; do
    dpkg -x "$package" "$prefix"
  done
  # development packages link to libraries by absolute path: point these links into the prefix
  while IFS= read -r -d '' link; do
    target=$(readlink "$link")
    [[ $target == /* && ! -e $target && -e $prefix$target ]] && ln -sfn "$prefix$target" "$link"
  done < <(find "$prefix" -type l -print0)
  multiarch=$(gcc -print-multiarch)
  # a compiler that is not the system's has no folder of this name, so CMake is told of it
  export CMAKE_PREFIX_PATH="$prefix/usr:$prefix/usr/lib/$multiarch/cmake${CMAKE_PREFIX_PATH:+:$CMAKE_PREFIX_PATH}"
  export CMAKE_LIBRARY_PATH="$prefix/usr/lib/$multiarch${CMAKE_LIBRARY_PATH:+:$CMAKE_LIBRARY_PATH}"
  export PATH="$prefix/usr/bin:$PATH"
  export LIBRARY_PATH="$prefix/usr/lib/$multiarch${LIBRARY_PATH:+:$LIBRARY_PATH}"
  export PKG_CONFIG_PATH="$prefix/usr/lib/$multiarch/pkgconfig:$prefix/usr/share/pkgconfig"
  export LD_LIBRARY_PATH="$prefix/usr/lib/$multiarch:$prefix/lib/$multiarch${LD_LIBRARY_PATH:+:$LD_LIBRARY_PATH}"
}

# configure_preset PRESET [cmake arguments...]
configure_preset() {
  local preset=$1
  shift
  local log="$root/build/$preset-configure.log"
  mkdir -p "$root/build"
  if command -v ccache >/dev/null; then  # what was compiled before, here or in another clone
    export CMAKE_CXX_COMPILER_LAUNCHER="${CMAKE_CXX_COMPILER_LAUNCHER-ccache}"
    export CMAKE_CUDA_COMPILER_LAUNCHER="${CMAKE_CUDA_COMPILER_LAUNCHER-ccache}"
    export CCACHE_BASEDIR="${CCACHE_BASEDIR-$root}"  # else paths of another clone differ
    # it takes the clone's path out of what is compiled, but is a path itself
    export CCACHE_IGNOREOPTIONS="${CCACHE_IGNOREOPTIONS--fmacro-prefix-map=*}"
  fi
  (cd "$root" && cmake --preset "$preset" "$@") >"$log" 2>&1 || {
    cat "$log" >&2
    fail "configuring preset $preset failed"
  }
  sed -n '/^-- pbdsurg /,/^-- Configuring/{/^-- Configuring/d;s/^-- //p}' "$log"
}

# build_preset PRESET [targets...]: configures and builds; all targets where none is named.
build_preset() {
  local preset=$1
  shift
  local jobs
  jobs=$(build_jobs)
  say "building preset $preset in build/$preset with $jobs job(s)"
  configure_preset "$preset"
  local -a targets=()
  (($# > 0)) && targets=(--target "$@")
  (cd "$root" && cmake --build --preset "$preset" --parallel "$jobs" "${targets[@]}") ||
    fail "building preset $preset failed"
}

# Benchmarks that there are sources of: a build folder may hold programs of others from before.
benchmark_names() { sed -n 's/^ *pbdsurg_add_bench(\([a-z_]*\).*/\1/p' "$root/bench/CMakeLists.txt"; }

# run_benchmarks BIN_DIR OUT_DIR [NAME]: each program NAME_bench, as NAME.json and NAME.txt: medians of
# five repetitions, those of one program interleaved.
run_benchmarks() {
  local bin=$1 out=$2 only=${3:-} program name count=0
  for name in $(benchmark_names); do
    program=$bin/${name}_bench
    [[ -x $program && (-z $only || $name == "$only") ]] || continue
    say "benchmark $name"
    "$program" --benchmark_repetitions=5 --benchmark_enable_random_interleaving=true \
      --benchmark_report_aggregates_only=true --benchmark_out="$out/$name.json" --benchmark_out_format=json | tee "$out/$name.txt" ||
      fail "benchmark $name failed"
    count=$((count + 1))
  done
  ((count > 0)) || fail "no benchmark was built in $bin"
}

json_string() { printf '"%s"' "$(printf '%s' "$1" | sed 's/\\/\\\\/g; s/"/\\"/g' | tr '\n\t' '  ')"; }

# describe_run COMMAND: members of a JSON object.
describe_run() {
  printf '"command": %s, "processor": %s, "processors": %d' "$(json_string "$1")" \
    "$(json_string "$(sed -n 's/^model name[^:]*: //p' /proc/cpuinfo | head -n 1)")" "$(nproc)"
}

# Programs that make tables, beside the benchmarks.
table_programs=(table1 table2 table3 convergence edits figure4 figure8 figure12 forces haptic_loop haptic_rate haptics held_force lesion neighbours replicas sheets contact sizes statics accuracy)

is_table() { [[ " ${table_programs[*]} " == *" $1 "* ]]; }

# What the demo draws or measures of itself: scripts/demo-figures.
demo_figures=(figure1 figure6 figure9 rig_ages)

is_demo_figure() { [[ " ${demo_figures[*]} " == *" $1 "* ]]; }

# run_demo_figures BIN_DIR OUT_DIR [NAME]: all, or one, if the demo was built.
run_demo_figures() {
  local bin=$1 out=$2 only=${3:-} name
  for name in "${demo_figures[@]}"; do
    [[ -z $only || $name == "$only" ]] || continue
    if [[ ! -x $bin/cholecystectomy ]]; then
      say "no $name: the demo was not built; configuring says what is missing"
      continue
    fi
    say "$name"
    "$root/scripts/demo-figures" "$name" "$bin" "$out" || fail "$name failed"
  done
}

# run_table BIN_DIR OUT_DIR NAME [arguments...]: one of them, if its needs were there to build it.
run_table() {
  local bin=$1 out=$2 name=$3
  shift 3
  if [[ ! -x $bin/$name ]]; then
    say "no $name: it was not built; configuring says what is missing"
    return
  fi
  say "$name"
  "$bin/$name" --out "$out" "$@"
}

# run_tables BIN_DIR OUT_DIR [NAME]: all, or one.
run_tables() {
  local bin=$1 out=$2 only=${3:-} name
  local -a failed=()
  for name in "${table_programs[@]}"; do
    [[ -z $only || $name == "$only" ]] || continue
    run_table "$bin" "$out" "$name" || failed+=("$name")
  done
  ((${#failed[@]} == 0)) || fail "${failed[*]} failed"
}
