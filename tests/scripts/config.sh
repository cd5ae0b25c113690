#!/bin/sh
# config - what make knows of the machine, in a folder of its own with a probe and a package manager that are made up:
# `make demo`, which installs packages, says what is left out as it is after the installation; another package that
# changes nothing gives the same build/config.mk, with its time, so that nothing is compiled anew.
set -e
here=$PWD
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
fail() { echo "check-config: FAILED: $1"; exit 1; }

mkdir -p "$folder/tools" "$folder/examples" "$folder/build"
cp "$here/Makefile" "$folder"
cat > "$folder/tools/probe" << 'END'
has=$(cat installed 2>/dev/null || echo 0)
for name in STB TINYGLTF EGL OSMESA GLFW RAYLIB CMOCKA X11 CXX; do echo "HAVE_$name := $has"; done
echo "EMBREE := $((has * 4))"
END
cat > "$folder/tools/deps" << 'END'
[ "$DEPS" = 0 ] && exit 0
echo 1 > installed
sleep 0.05
date >> packages
END
echo 'echo "the pictures"' > "$folder/examples/demo.sh"
cd "$folder"
touch packages build/gallery
run() { make -s --no-print-directory PROGRAMS= EXAMPLES= PACKAGES=packages "$@" 2> errors; }

said=$(run DEPS=0 demo)
case $said in *'no stb'*'the pictures') ;; *) fail "without packages: $said" ;; esac
said=$(run DEPS=1 demo)
[ "$said" = 'the pictures' ] || fail "with packages that were just installed: $said"

before=$(stat -c %Y.%y build/config.mk)
sleep 0.05
date >> packages
run DEPS=0 demo > /dev/null
[ "$before" = "$(stat -c %Y.%y build/config.mk)" ] || fail 'build/config.mk is new where nothing changed'
[ build/config.asked -nt packages ] || fail 'the machine was not asked after a package came'
echo 'check-config: what is left out is said after the installation, and nothing is new where nothing changed'
