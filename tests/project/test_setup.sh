# scripts/setup.sh with stand-ins for apt-get, dpkg-query, sudo, cmake and ninja: what it installs, asks and says, when
# it builds, and that a second time it says and does nothing.
# shellcheck disable=SC2016,SC2317
set -euo pipefail
root=$1
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
failed=0

check() {
    local what=$1
    shift
    "$@" || { echo "FAILED: $what"; failed=1; }
}
says() { grep -qF -- "$1" "$work/err"; }
did() { grep -qF -- "$1" "$work/done"; }

# stand_in NAME BODY
stand_in() {
    printf '#!/bin/bash\n%s\n' "$2" >"$work/bin/$1"
    chmod +x "$work/bin/$1"
}

# set_up COMMAND...: in a shell that sees the stand-ins first; its messages to $work/err, its status in $status.
set_up() {
    status=0
    : >"$work/done"
    WORK=$work PATH=$work/bin:$PATH bash -c '
        set -euo pipefail
        root=$WORK/tree
        source "$1"
        shift
        "$@"' _ "$root/scripts/setup.sh" "$@" >"$work/out" 2>"$work/err" || status=$?
    [[ ! -s $work/out ]] || { echo "FAILED: standard output is not empty:"; cat "$work/out"; failed=1; }
}

mkdir -p "$work/bin" "$work/tree/src" "$work/build"
printf '# a note\none\ntwo # why\n\nthree\n' >"$work/list"
: >"$work/installed"
stand_in dpkg-query 'grep -qx "${@: -1}" "$WORK/installed" && echo installed || echo not-installed'
stand_in apt-get 'echo "apt-get $*" >>"$WORK/done"
    [[ " $* " != *" install "* ]] || printf "%s\n" "$@" >>"$WORK/installed"'
stand_in sudo 'echo "sudo $1" >>"$WORK/done"; [[ $1 == -v ]] || exec "$@"'
stand_in cmake 'echo cmake >>"$WORK/done"'
stand_in ninja 'echo ninja >>"$WORK/done"; echo "[1/2] half"; [[ ! -e $WORK/broken ]] || { echo "x.c: broken"; exit 1; }'

echo two >"$work/installed"
set_up ensure_packages "$work/build" "$work/list"
check "packages install" test "$status" = 0
check "only the missing packages are installed" did "--no-install-recommends one three"
check "the lists are updated first" did "update"
((EUID == 0)) || check "sudo is explained" says "sudo is needed to install 2 packages: one three"
((EUID != 0)) || check "root needs no sudo" bash -c "! grep -q sudo '$work/done'"

set_up ensure_packages "$work/build" "$work/list"
check "the second time is silent" test ! -s "$work/err" -a ! -s "$work/done"

echo four >>"$work/list"
rm "$work/bin/apt-get"
stand_in apt-get 'echo "E: no such package"; [[ " $* " != *" install "* ]]'
set_up ensure_packages "$work/build" "$work/list"
check "a refused install fails" test "$status" = 1
check "and shows apt's words" says "E: no such package"
check "and names the package" says "apt-get install four failed"
set_up ensure_packages "$work/build" "$work/list"
check "and is tried again" test "$status" = 1

mkdir -p "$work/few"
for tool in bash cat cksum tr sed env grep; do ln -sf "$(command -v $tool)" "$work/few/$tool"; done
status=0
PATH=$work/few bash -c 'set -euo pipefail; root=/; source "$1"; ensure_packages "$2" "$3"' _ \
    "$root/scripts/setup.sh" "$work/build" "$work/list" 2>"$work/err" || status=$?
check "without apt it fails" test "$status" = 1
check "without apt it names the packages" says "one two three four"

echo 1 >"$work/tree/src/a.c"
sleep 0.02
set_up ensure_build "$work/build" program perigee
check "the first time builds" test "$status" = 0
check "configured" did cmake
check "built" did ninja
check "says so" says "building program"
set_up ensure_build "$work/build" program perigee
check "nothing new: silent and idle" test ! -s "$work/err" -a ! -s "$work/done"
sleep 0.02
echo 2 >"$work/tree/src/a.c"
: >"$work/broken"
set_up ensure_build "$work/build" program perigee
check "a broken build fails" test "$status" = 1
check "and shows the compiler's words" says "x.c: broken"
rm "$work/broken"
set_up ensure_build "$work/build" program perigee
check "and is built again once mended" did ninja
sleep 0.02
: >"$work/tree/src/new.c"
set_up ensure_build "$work/build" tests all
check "a new file builds" did ninja
set_up ensure_build "$work/build" program perigee
check "building all covers the program" test ! -s "$work/done"

stand_in perigee 'echo "perigee $*" >>"$WORK/done"; echo chatter; : >"$PERIGEE_EARTH"'
export PERIGEE_EARTH=$work/earth.planet
set_up ensure_earth "$work/bin/perigee"
check "the default Earth is made" did "perigee import --earth"
set_up ensure_earth "$work/bin/perigee"
check "once" test ! -s "$work/err" -a ! -s "$work/done"
rm "$PERIGEE_EARTH"
stand_in perigee 'exit 1'
set_up ensure_earth "$work/bin/perigee"
check "a failure is told" says "the default Earth could not be made"
check "and is a failure" test "$status" = 1
exit $failed
