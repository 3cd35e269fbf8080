#!/usr/bin/env bash
# Checks of the sources that need no run: `bash tests/lint/lint.sh [BUILD]`. One line a check; exit 1 if any failed.
# BUILD (build/ unless given) has been configured; clang-tidy reads its compile_commands.json.
#
# clang-tidy looks at the .cpp files that changed since a base commit, uncommitted changes included, and for a
# changed header at one .cpp that includes it. The base is PLIANT_LINT_BASE if set; else where this branch left
# origin/main; on main itself, the commit before. More than PLIANT_LINT_LIMIT files (12; 0: no limit) take too long:
# those with the most changed lines are taken, and the others are named.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
root="$PWD"
build="${1:-build}"
failed=0

report() { # CODE NAME DETAIL
  if (($1 == 0)); then printf 'ok    %s: %s\n' "$2" "$3"; else
    printf 'FAIL  %s: %s\n' "$2" "$3"
    failed=1
  fi
}
skip() { printf 'skip  %s: %s\n' "$1" "$2"; }

# The clone may belong to another user than the one who runs this.
repo() { git -c safe.directory="$root" "$@"; }
is_clone=false
if command -v git >/dev/null && [[ "$(repo rev-parse --show-toplevel 2>/dev/null)" == "$root" ]]; then is_clone=true; fi

# Tracked and new files that git does not ignore; without a clone, everything but the build folders and outputs.
list_files() {
  if $is_clone; then
    repo ls-files -z --cached --others --exclude-standard
  else
    find . \( -path './build*' -o -path './out*' -o -path './.git' \) -prune -o -type f -print0 | sed -z 's#^\./##'
  fi
}
files=()
while IFS= read -r -d '' file; do [[ -f "$file" ]] && files+=("$file"); done < <(list_files | sort -zu)
text=() code=() sources=()
for file in "${files[@]}"; do
  # Empty files and files that grep takes for text.
  if [[ ! -s "$file" ]] || LC_ALL=C grep -qI '' "$file"; then text+=("$file"); fi
  case "$file" in
    *.h | *.cpp) code+=("$file") sources+=("$file") ;;
    *.comp | *.glsl | *.vert | *.frag) sources+=("$file") ;;
  esac
done

check_format() {
  if ! command -v clang-format >/dev/null; then skip format "clang-format is not installed"; return; fi
  local found count
  # The first place of each file is enough to find it.
  found="$(printf '%s\0' "${code[@]}" | xargs -0 clang-format --dry-run -Werror 2>&1 |
    grep -E '^[^ :]+:[0-9]+:[0-9]+: ' | LC_ALL=C sort -s -u -t : -k 1,1 || true)"
  if [[ -z "$found" ]]; then report 0 format "clang-format on ${#code[@]} files"; return; fi
  count="$(wc -l <<<"$found")"
  printf '%s\n' "$found"
  report 1 format "$count of ${#code[@]} files; to mend: clang-format -i$(cut -d : -f 1 <<<"$found" | tr '\n' ' ' | sed 's/^/ /')"
}

# check_absent NAME PATTERN WHY: no line of a text file matches. The patterns must not match themselves here.
check_absent() {
  local found
  found="$(printf '%s\0' "${text[@]}" | LC_ALL=C xargs -0 grep -HnE -e "$2" -- || true)"
  if [[ -n "$found" ]]; then
    cut -c 1-200 <<<"$found"
    report 1 "$1" "$3"
  else
    report 0 "$1" "${#text[@]} text files"
  fi
}

check_length() {
  local file lines long=0
  for file in "${sources[@]}"; do
    lines="$(wc -l <"$file")"
    if ((lines > 500)); then
      printf '%s: %d lines\n' "$file" "$lines"
      long=$((long + 1))
    fi
  done
  if ((long)); then report 1 length "$long files of more than 500 lines: divide them"; else
    report 0 length "${#sources[@]} files of at most 500 lines"
  fi
}

# base_commit: what clang-tidy compares with; empty where history does not reach.
base_commit() {
  local base
  if [[ -n "${PLIANT_LINT_BASE:-}" ]]; then
    repo rev-parse --verify --quiet "$PLIANT_LINT_BASE^{commit}" || true
    return
  fi
  base="$(repo merge-base HEAD origin/main 2>/dev/null || true)"
  if [[ -z "$base" || "$base" == "$(repo rev-parse HEAD)" ]]; then
    base="$(repo rev-parse --verify --quiet 'HEAD~1^{commit}' || true)"
  fi
  printf '%s' "$base"
}

# changed_sources BASE: "LINES<tab>FILE" of changed .cpp and .h files, those that git does not know yet included.
changed_sources() {
  local file
  repo diff --numstat --no-renames --diff-filter=d "$1" -- '*.cpp' '*.h' | awk -F '\t' '{ print $1 + $2 "\t" $3 }'
  while IFS= read -r file; do printf '%d\t%s\n' "$(wc -l <"$file")" "$file"; done < <(
    repo ls-files --others --exclude-standard -- '*.cpp' '*.h')
}

check_tidy() {
  if ! command -v clang-tidy >/dev/null; then skip clang-tidy "not installed"; return; fi
  if [[ ! -f "$build/compile_commands.json" ]]; then skip clang-tidy "$build is not configured"; return; fi
  if ! $is_clone; then skip clang-tidy "not a git clone, so nothing says which files changed"; return; fi
  local base
  base="$(base_commit)"
  if [[ -z "$base" ]]; then
    if [[ -n "${PLIANT_LINT_BASE:-}" ]]; then report 1 clang-tidy "PLIANT_LINT_BASE names no commit here: $PLIANT_LINT_BASE"; else
      skip clang-tidy "this clone has a single commit, so nothing says which files changed; set PLIANT_LINT_BASE"
    fi
    return
  fi

  # One entry a file: what is compiled for several instruction sets is the same text to clang-tidy.
  local database="$build/lint"
  mkdir -p "$database"
  python3 tests/lint/one_entry.py "$build/compile_commands.json" "$database/compile_commands.json"
  local chosen=() left=() limit="${PLIANT_LINT_LIMIT:-12}" file
  while IFS= read -r file; do
    if ((limit == 0 || ${#chosen[@]} < limit)); then chosen+=("$file"); else left+=("$file"); fi
  done < <(changed_sources "$base" | python3 tests/lint/units.py "$database/compile_commands.json")
  local since
  since="since $(repo rev-parse --short "$base")"
  if ((${#chosen[@]} == 0)); then report 0 clang-tidy "no C++ file changed $since"; return; fi
  if ((${#left[@]})); then
    printf 'clang-tidy: %d files changed; the %d with the most changed lines are checked, not these: %s\n' \
      "$((${#chosen[@]} + ${#left[@]}))" "${#chosen[@]}" "${left[*]}"
    printf 'clang-tidy: to check all: PLIANT_LINT_LIMIT=0 bash tests/lint/lint.sh\n'
  fi
  # Warnings are g++'s business; and clang 14 does not know the names of x86-64 levels that g++ 12 asks the
  # processor for.
  local options=(--quiet -p "$database" --extra-arg=-Wno-error --extra-arg=-Wno-unknown-warning-option
    '--extra-arg=-D__builtin_cpu_supports(name)=(*(name)!=0)')
  local status=0
  # shellcheck disable=SC2016 # expanded by the inner bash
  printf '%s\0' "${chosen[@]}" | xargs -0 -P "$(nproc)" -n 1 bash -c '
    options=("$@"); file="${options[-1]}"; unset "options[-1]"
    if ! output="$(clang-tidy "${options[@]}" "$file" 2>&1)"; then
      grep -vE "^[0-9]+ warnings?( and [0-9]+ errors?)? generated" <<<"$output"; exit 1; fi' \
    clang-tidy "${options[@]}" || status=$?
  report "$status" clang-tidy "${#chosen[@]} files changed $since${left[*]:+ (of $((${#chosen[@]} + ${#left[@]})))}"
}

check_format
check_absent paths '(^|[^[:alnum:]_.~}-])/(work|root|home)/[[:alnum:]_.]' "a path of one machine is in the sources"
check_absent markers '\b(TO[D]O|FIXM[E])\b' "unfinished work is marked in the sources: finish it or open an issue"
check_length
check_tidy
exit "$failed"
