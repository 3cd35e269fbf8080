#!/usr/bin/env bash
# The main job: an armadillo and a bunny of elastic matter fall to the floor; simulated, rendered, stored.
set -euo pipefail
# shellcheck source=examples/setup.sh
source "$(dirname "${BASH_SOURCE[0]}")/setup.sh"

usage() {
  cat <<'TEXT'
Usage: examples/main-job.sh [--out FOLDER] [--meshes] [options of `pliant run`...]

Installs what is missing (Debian 12, as root or through sudo), builds the program in build/, fetches the meshes
into the user's cache and runs examples/main-job.toml.

  --out FOLDER   where the run goes; out/main-job of this project unless given. One that is occupied is left
                 alone, and a number is added to the name.
  --meshes       only fetch the meshes
  --help         this text

Everything else is handed to `pliant run`, for example:
  examples/main-job.sh --frames 10 --backend gl
  examples/main-job.sh --out /tmp/drop --video
TEXT
}

out="$pliant_root/out/main-job"
only_meshes=false
extra=()
while (($#)); do
  case "$1" in
    -h | --help) usage; exit 0 ;;
    --meshes) only_meshes=true ;;
    --out)
      (($# > 1)) || { usage >&2; exit 2; }
      out="$2"
      shift
      ;;
    --out=*) out="${1#--out=}" ;;
    *) extra+=("$1") ;;
  esac
  shift
done
[[ -n "$out" ]] || { usage >&2; exit 2; }

if $only_meshes; then
  fetch_meshes
  exit 0
fi

install_packages "${pliant_program_packages[@]}"
fetch_meshes
# With the packages for tests at hand the build keeps them, so that the two commands share one build folder.
with_tests=OFF
[[ -z "$(missing_packages "${pliant_test_packages[@]}")" ]] && with_tests=ON
build "$with_tests" pliant

occupied() { [[ -e "$1" && ! -d "$1" ]] || [[ -d "$1" && -n "$(ls -A "$1")" ]]; }
if occupied "$out"; then
  number=2
  while occupied "${out%/}-$number"; do number=$((number + 1)); done
  say "$out is occupied: writing to ${out%/}-$number"
  out="${out%/}-$number"
fi

stage "Running the main job"
code=0
"$pliant_build/pliant" run "$pliant_root/examples/main-job.toml" --out "$out" ${extra[@]+"${extra[@]}"} || code=$?
if ((code == 130 || code == 143)); then exit "$code"; fi # stopped on request, which it has said
if ((code != 0)); then
  printf 'error: pliant run ended with code %d; its message is above\n' "$code" >&2
  if [[ -d "$out" ]]; then
    printf '       what it had written is in %s\n' "$out" >&2
    if [[ -n "$(ls -A "$out/checkpoints" 2>/dev/null)" ]]; then
      printf '       to go on from its last checkpoint: %s run %s --out %s --resume%s\n' "$pliant_build/pliant" \
        "$pliant_root/examples/main-job.toml" "$out" "${extra[*]+ ${extra[*]}}" >&2
    fi
  fi
  exit "$code"
fi

# The run's folder, file by file; what these options left out is not named.
stage "Done: $out"
shopt -s nullglob
pictures=("$out"/frames/*.png)
((${#pictures[@]})) && say "pictures  $out/frames/ (${#pictures[@]} PNG)"
[[ -e "$out/film.mp4" ]] && say "film      $out/film.mp4"
[[ -e "$out/run.xmf" ]] && say "data      $out/run.xmf (open in ParaView)"
[[ -e "$out/run.vtkhdf" ]] && say "          $out/run.vtkhdf"
[[ -e "$out/run.json" ]] && say "report    $out/run.json"
[[ -e "$out/statistics.csv" ]] && say "          $out/statistics.csv (a row a step)"
exit 0
