#!/usr/bin/env bash
# The pins' tests against libgpiod 2 of Debian 13, in the same kernel: debian13.sh CACHE_DIR. Wants mmdebstrap
# and root; the first time it fetches some 200 MB.
set -euo pipefail
here=$(dirname "$(readlink -f "$0")")
source=$(readlink -f "$here/../..")
root=${1:-${XDG_CACHE_HOME:-$HOME/.cache}/voidpath}/debian13
if [ ! -x "$root/usr/bin/g++" ]; then
  mkdir -p "$(dirname "$root")"
  mmdebstrap --quiet --variant=buildd --include=libgpiod-dev,catch2 trixie "$root.new"
  mv "$root.new" "$root"
fi
rm -rf "$root/voidpath"
mkdir -p "$root/voidpath/tests" "$root/voidpath/catch2-3/catch2"
cp -r "$source/firmware-io" "$root/voidpath/"
cp -r "$here" "$root/voidpath/tests/"
# Catch2 3 under the names of Catch2 2.
cat >"$root/voidpath/catch2-3/catch2/catch.hpp" <<'EOT'
#pragma once
#include <catch2/catch_all.hpp>
namespace Catch {
using namespace Matchers;
inline auto Contains(const std::string& text) { return ContainsSubstring(text); }
}  // namespace Catch
EOT
chroot "$root" sh -ec 'cd /voidpath
g++ -std=c++20 -O1 -Wall -Wextra -Wshadow -Wconversion -Wsign-conversion -Werror -Icatch2-3 -I. \
  firmware-io/clock.cpp firmware-io/gpio/find_line.cpp firmware-io/gpio/gpiod_pins_v2.cpp \
  firmware-io/gpio/relay.cpp firmware-io/gpio/emergency_stop.cpp tests/gpio/pins_test.cpp \
  -o test_gpio_sim -lgpiod -lCatch2Main -lCatch2
g++ -std=c++20 -O1 tests/gpio/init.cpp -o gpio_init'
"$here/run.sh" /voidpath "" "$root"
