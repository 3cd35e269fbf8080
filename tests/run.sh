#!/usr/bin/env bash
# All tests: the main job's set-up with what tests need, the whole build, lint, then ctest.
set -euo pipefail
# shellcheck source=examples/setup.sh
source "$(dirname "${BASH_SOURCE[0]}")/../examples/setup.sh"

usage() {
  cat <<'TEXT'
Usage: tests/run.sh [--setup-only] [options of ctest...]

Installs what is missing (Debian 12, as root or through sudo), fetches the meshes, builds everything in build/,
checks the sources (tests/lint/lint.sh) and runs all tests. The exit code is 0 only if all of it passed.

  --setup-only   install and build; run nothing
  --help         this text

Everything else is handed to ctest, for example:
  tests/run.sh -R 'device/'        only tests whose name matches
  tests/run.sh --rerun-failed
PLIANT_LINT=0 leaves the lint out; PLIANT_LINT_BASE=COMMIT names what clang-tidy compares with.
TEXT
}

setup_only=false
options=()
for argument in "$@"; do
  case "$argument" in
    -h | --help) usage; exit 0 ;;
    --setup-only) setup_only=true ;;
    *) options+=("$argument") ;;
  esac
done

install_packages "${pliant_program_packages[@]}" "${pliant_test_packages[@]}"
# Tests that need no mesh run without; the set-up on its own must be complete.
(fetch_meshes) || {
  if $setup_only; then exit 1; fi
  say "warning: going on without the meshes; the tests that need them will say so"
}
build ON all
if $setup_only; then
  say "set up: the program is $pliant_build/pliant, the tests run with tests/run.sh"
  exit 0
fi

lint=0
if [[ "${PLIANT_LINT:-1}" != 0 ]]; then
  stage "Lint"
  bash "$pliant_root/tests/lint/lint.sh" "$pliant_build" || lint=$?
fi

# Two tests at a time, each with up to two threads of its own: threads that wait must sleep, not spin.
stage "Tests"
export OMP_WAIT_POLICY="${OMP_WAIT_POLICY:-passive}"
tests=0
ctest --test-dir "$pliant_build" --output-on-failure --no-tests=error -j 2 \
  ${options[@]+"${options[@]}"} </dev/null || tests=$?
if ((lint != 0)); then
  printf '\nerror: lint failed; its messages are above the tests\n' >&2
  exit 1
fi
exit "$tests"
