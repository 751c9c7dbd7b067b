#!/usr/bin/env bash
# Builds the user-mode Linux of these tests from Debian's linux-source-6.1, once for each configuration and
# source version, and prints the program's path. Some five minutes of processor time the first time.
set -euo pipefail
here=$(dirname "$(readlink -f "$0")")
source=/usr/src/linux-source-6.1.tar.xz
jobs=${1:-$(nproc)}

version=$(dpkg-query -W -f='${Version}' linux-source-6.1)
key=$( { cat "$here/kernel.config"; echo "$version"; } | sha256sum | cut -c1-16)
cache=${XDG_CACHE_HOME:-$HOME/.cache}/voidpath
kernel=$cache/linux-um-$key
if [ ! -x "$kernel" ]; then
  echo "building a user-mode Linux $version for $kernel" >&2
  mkdir -p "$cache"
  work=$(mktemp -d "$cache/build-XXXXXX")
  trap 'rm -rf "$work"' EXIT
  tar -C "$work" -xf "$source" --strip-components=1
  make -C "$work" -s ARCH=um KCONFIG_ALLCONFIG="$here/kernel.config" allnoconfig >&2
  while IFS= read -r line; do  # what kconfig dropped silently would only show as a failing test
    case $line in
      CONFIG_*=y) grep -qx "$line" "$work/.config" || { echo "the kernel cannot have $line" >&2; exit 1; } ;;
    esac
  done <"$here/kernel.config"
  nice -n 10 make -C "$work" -s ARCH=um -j"$jobs" linux >"$work/log" 2>&1 || { tail -n 30 "$work/log" >&2; exit 1; }
  strip -o "$work/linux.stripped" "$work/linux"
  mv "$work/linux.stripped" "$kernel"  # whole or not at all
fi
echo "$kernel"
