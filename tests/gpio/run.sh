#!/usr/bin/env bash
# Runs the tests of the pins and of the USB printer inside a user-mode Linux: run.sh BIN_DIR [FILTER]
# FILTER is Catch's, without spaces: ~[usb], or *relay*.
set -euo pipefail
here=$(dirname "$(readlink -f "$0")")
bin=$(readlink -f "$1")
kernel=$("$here/build_kernel.sh")
out=$(mktemp)
trap 'rm -f "$out"' EXIT
# The machine sees the host's files. What its command line does not know becomes init's environment.
timeout 120 "$kernel" mem=96M rootfstype=hostfs rootflags=/ rw init="$bin/gpio_init" con=null con0=fd:0,fd:1 \
  ssl=null quiet panic=-1 TEST_PROGRAM="$bin/test_gpio_sim" ${2:+TEST_FILTER="$2"} </dev/null 2>&1 | tee "$out"
grep -q '^RC=0' "$out"
