#!/usr/bin/env bash
# Runs the tests of the pins and of the USB printer inside a user-mode Linux: run.sh BIN_DIR [FILTER [ROOT]]
# FILTER is Catch's, without spaces: ~[usb], or *relay*. ROOT: the file tree it sees, BIN_DIR within it.
set -euo pipefail
here=$(dirname "$(readlink -f "$0")")
filter=${2:-}
root=${3:-/}
bin=$1
[ "$root" != / ] || bin=$(readlink -f "$1")
kernel=$("$here/build_kernel.sh")
out=$(mktemp)
trap 'rm -f "$out"' EXIT
# What the command line's reader does not know becomes init's environment.
timeout 120 "$kernel" mem=96M rootfstype=hostfs rootflags="$root" rw init="$bin/gpio_init" con=null \
  con0=fd:0,fd:1 ssl=null quiet panic=-1 TEST_PROGRAM="$bin/test_gpio_sim" ${filter:+TEST_FILTER="$filter"} \
  </dev/null 2>&1 | tee "$out"
grep -q '^RC=0' "$out"
