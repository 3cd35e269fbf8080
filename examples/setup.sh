# shellcheck shell=bash disable=SC2034 # the lists are for those who source this
# What the two commands share: packages, meshes, configuring and building. Sourced, not run, by
# examples/main-job.sh and tests/run.sh. What is there already is left alone, and then no network is needed.

pliant_root="$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)"
pliant_build="$pliant_root/build"
pliant_meshes="${XDG_CACHE_HOME:-${HOME:?HOME is not set: set it, or XDG_CACHE_HOME}/.cache}/pliant/meshes"

# Names of Debian 12 packages. Ubuntu 24.04 has them too.
pliant_program_packages=(
  g++ cmake ninja-build ccache pkg-config
  libeigen3-dev libhdf5-dev libtomlplusplus-dev nlohmann-json3-dev libcli11-dev libfmt-dev
  libpng-dev python3-glad libegl1 libgl1-mesa-dri libosmesa6 ffmpeg)
pliant_test_packages=(
  libgtest-dev libgmock-dev librapidcheck-dev libbenchmark-dev python3-h5py python3-numpy glslang-tools
  clang-format clang-tidy libomp-dev git) # libomp-dev: clang-tidy's omp.h

say() { printf '%s\n' "$*"; }
stage() { printf '\n== %s\n' "$*"; }
fail() {
  printf 'error: %s\n' "$1" >&2
  shift
  local line
  for line in "$@"; do printf '       %s\n' "$line" >&2; done
  exit 1
}

# missing_packages NAME...: those of them that dpkg does not know as installed, one a line.
missing_packages() {
  local name
  for name in "$@"; do
    [[ "$(dpkg-query -W -f '${db:Status-Status}' "$name" 2>/dev/null)" == installed* ]] || say "$name"
  done
}

# as_root COMMAND...: runs it as root, directly or through sudo. Never waits for a password where nobody can type.
as_root() {
  if ((EUID == 0)); then
    "$@" </dev/null
  elif [[ -n "${CI:-}" || ! -t 0 ]]; then
    sudo -n "$@" </dev/null
  else
    sudo "$@"
  fi
}
can_be_root() { ((EUID == 0)) || command -v sudo >/dev/null; }

update_package_lists() {
  as_root apt-get -q update || say "warning: apt-get update failed; going on with the package lists that are here"
}

# install_packages NAME...: installs what is missing; touches no network when nothing is.
install_packages() {
  if ! command -v dpkg-query >/dev/null || ! command -v apt-get >/dev/null; then
    fail "this is not a Debian system: dpkg-query or apt-get is missing" \
      "Install by hand what corresponds to: $*" "then: cmake --preset release && cmake --build --preset release"
  fi
  local missing
  mapfile -t missing < <(missing_packages "$@")
  if ((${#missing[@]} == 0)); then
    say "packages: all ${#} are installed"
    return
  fi
  local by_hand="apt-get update && apt-get install -y --no-install-recommends ${missing[*]}"
  local noun=packages
  if ((${#missing[@]} == 1)); then noun=package; fi
  stage "Installing ${#missing[@]} $noun: ${missing[*]}"
  can_be_root || fail "packages are missing, and this is neither root nor a machine with sudo" \
    "Have someone run, as root:" "  $by_hand" "then run this again."
  update_package_lists
  as_root env DEBIAN_FRONTEND=noninteractive apt-get -q -y -o Dpkg::Use-Pty=0 -o DPkg::Lock::Timeout=300 \
    install --no-install-recommends "${missing[@]}" || {
    mapfile -t missing < <(missing_packages "${missing[@]}")
    fail "apt-get could not install: ${missing[*]:-(everything arrived, but apt-get reported a fault)}" \
      "Its messages are above. Without network, or without the right to be root, it cannot." \
      "To see it alone, as root:" "  $by_hand" "then run this again."
  }
}

# mesh_present NAME: where the program would find it.
mesh_present() { [[ -s "$pliant_meshes/$1" || (-n "${PLIANT_MESHES:-}" && -s "$PLIANT_MESHES/$1") ]]; }

download_package() { # NAME FOLDER
  local options=(-q)
  # Root's own temporary folder is closed to apt's user; the download is as safe without it (hashes are checked).
  if ((EUID == 0)); then options+=(-o APT::Sandbox::User=root); fi
  (cd "$2" && apt-get "${options[@]}" download "$1" </dev/null) && compgen -G "$2/$1_*.deb" >/dev/null
}

# fetch_meshes: armadillo and bunny, out of Debian's package of CGAL demonstrations, into the user's cache. The
# package itself is opened, not installed: slim images leave /usr/share/doc out when they install.
fetch_meshes() {
  local names=(armadillo.off bunny00.off) wanted=() name
  for name in "${names[@]}"; do mesh_present "$name" || wanted+=("$name"); done
  if ((${#wanted[@]} == 0)); then
    say "meshes: ${names[*]} are in ${pliant_meshes/#"${HOME:-/nowhere}"/\~}"
    return
  fi
  stage "Fetching meshes: ${wanted[*]}"
  local advice=("The meshes come out of Debian's package libcgal-demo."
    "With network, run this again; or put the files into $pliant_meshes"
    "or into a folder that PLIANT_MESHES names.")
  mkdir -p "$pliant_meshes" || fail "cannot make the folder $pliant_meshes" "Set XDG_CACHE_HOME to one that can be written."
  local work
  work="$(mktemp -d "${TMPDIR:-/tmp}/pliant-meshes.XXXXXX")"
  # shellcheck disable=SC2064 # the folder of now is meant
  trap "rm -rf '$work'" EXIT
  if ! download_package libcgal-demo "$work" 2>"$work/log"; then
    # Fresh images have no package lists, and old lists name files that are gone.
    if can_be_root; then update_package_lists; fi
    download_package libcgal-demo "$work" || fail "the package libcgal-demo could not be downloaded" "${advice[@]}"
  fi
  dpkg-deb -x "$work"/libcgal-demo_*.deb "$work/package" || fail "libcgal-demo could not be unpacked" "${advice[@]}"
  tar -xzf "$work/package/usr/share/doc/libcgal-dev/data.tar.gz" -C "$work" "${wanted[@]/#/data/meshes/}" ||
    fail "this version of libcgal-demo lacks: ${wanted[*]}" "${advice[@]}"
  for name in "${wanted[@]}"; do
    # Copied beside its place and renamed: an interrupted copy never looks like a mesh.
    cp "$work/data/meshes/$name" "$pliant_meshes/.$name.part"
    mv "$pliant_meshes/.$name.part" "$pliant_meshes/$name"
    say "  $pliant_meshes/$name"
  done
  rm -rf "$work"
  trap - EXIT
}

# Compilers at once: one a processor, and no more than there is memory for, at about 1 GiB each.
build_jobs() {
  local jobs memory
  jobs="$(nproc)"
  memory="$(awk '/^MemAvailable:/ { print int($2 / 1048576) }' /proc/meminfo 2>/dev/null || say "$jobs")"
  ((memory < 1)) && memory=1
  say "$((jobs < memory ? jobs : memory))"
}

# build TESTS TARGET: configures build/ (Release) and builds. TESTS is ON or OFF, for tests and benchmarks.
build() {
  stage "Building ($2, in build/)"
  cmake -S "$pliant_root" -B "$pliant_build" -G Ninja -DCMAKE_BUILD_TYPE=Release -DPLIANT_TESTS="$1" \
    -DPLIANT_BENCH="$1" --log-level=WARNING >/dev/null ||
    fail "cmake could not configure; its messages are above" \
      "If build/ was made by another user, generator or source folder, remove it and run this again:" \
      "  rm -rf '$pliant_build'"
  cmake --build "$pliant_build" --target "$2" --parallel "${CMAKE_BUILD_PARALLEL_LEVEL:-$(build_jobs)}" ||
    fail "the build failed; the compiler's messages are above"
}
