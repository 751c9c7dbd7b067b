#!/usr/bin/env bash
# The main job on the mock printer: demo.sh BIN_DIR MODEL. Everything happens in a scratch folder.
set -euo pipefail

bin=$(readlink -f "$1")
model=$(readlink -f "$2")
[ -f "$model" ] || { echo "demo: $2: no such file" >&2; exit 3; }
dir=$(mktemp -d "${TMPDIR:-/tmp}/voidpath-demo-XXXXXX")
name=$(basename "$model")
port=$((20000 + RANDOM % 20000))
config=$dir/voidpath.yaml
mkdir "$dir/inbox"

say() { printf '\n\033[1m== %s\033[0m\n' "$*"; }
stop() {
  kill "${daemon:-}" 2>/dev/null && wait "$daemon" 2>/dev/null || true
  kill "${mock:-}" 2>/dev/null && wait "$mock" 2>/dev/null || true
  rm -rf "$dir"
}
trap stop EXIT
vp() { "$bin/voidpath" "$@" --config "$config"; }
# Waits until a command succeeds.
await() {
  local tries=$1
  shift
  until "$@" >/dev/null 2>&1; do
    tries=$((tries - 1))
    [ "$tries" -gt 0 ] || return 1
    sleep 0.1
  done
}

cat >"$config" <<EOT
state_dir: $dir/state
web: {listen: "127.0.0.1:$port"}
settle_s: 0.5
orient: {budget_s: 10}
printers:
  - name: demo
    profile: generic-marlin
    port: $dir/printer
    watch: [$dir/inbox]
    clock: $dir/clock
EOT

say "a mock printer, as fast as it can, and the daemon"
"$bin/mock-printer" --link "$dir/printer" --clock "$dir/clock" --log "$dir/executed.log" --speed 0 \
  >"$dir/mock.out" 2>"$dir/mock.err" &
mock=$!
await 100 grep -q ready "$dir/mock.out" || { cat "$dir/mock.err" >&2; exit 1; }
"$bin/voidpathd" --config "$config" 2>"$dir/daemon.err" &
daemon=$!
await 100 vp status || { cat "$dir/daemon.err" >&2; exit 1; }
echo "watching $dir/inbox; status page at http://127.0.0.1:$port/"

say "dropping $name into the watched folder; the bed is clear"
vp bed-clear
cp "$model" "$dir/inbox/.$name.copying" && mv "$dir/inbox/.$name.copying" "$dir/inbox/$name"
vp watch

say "how it went"
report=$(find "$dir/inbox/done" "$dir/inbox/failed" -name '*.report.txt' 2>/dev/null | head -n 1 || true)
if [ -z "$report" ]; then
  vp queue
  tail -n 20 "$dir/daemon.err" >&2
  exit 1
fi
cat "$report"

say "the row in the calibration data (voidpath history --csv)"
vp history --csv

grep -q ': done$' "$report"
