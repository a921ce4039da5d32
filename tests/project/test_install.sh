# The installed tree is complete and works: `cmake --install` into the build folder, the example built against it by CMake
# and by pkg-config, run on a small planet that the installed program imports, and the symbols the library shows.
set -euo pipefail
root=$1 build=$2 cc=$3 sanitize=${4:-}
work=$build/install-test
prefix=$work/prefix
rm -rf "$work"
mkdir -p "$work"
cd "$work"

fail() {
    echo "FAILED: $*"
    exit 1
}

# try LOG COMMAND...: shows the log when the command fails.
try() {
    local log=$1
    shift
    "$@" >"$log" 2>&1 || { cat "$log"; fail "$*"; }
}

try install.log cmake --install "$build" --prefix "$prefix"
lib=$(dirname "$(find "$prefix" -name libperigee.so)")
for file in bin/perigee include/perigee.h share/perigee/atlas-relief-metres.csv share/man/man1/perigee.1 share/man/man1/perigee-compare.1 share/man/man1/perigee-import.1 \
    share/doc/perigee/LICENSE; do
    [[ -s $prefix/$file ]] || fail "$file is not installed"
done
for file in pkgconfig/perigee.pc cmake/perigee/perigee-config.cmake cmake/perigee/perigee-config-version.cmake; do
    [[ -s $lib/$file ]] || fail "$file is not installed"
done
[[ -n $(find "$prefix/share/perigee/flights" -name '*.json') ]] || fail "no flights are installed"
[[ $("$prefix/bin/perigee" --version) == *[0-9].[0-9]* ]] || fail "perigee --version names no version"

# Exactly the functions of perigee.h are shown.
nm -D --defined-only "$lib/libperigee.so" | awk '$2 ~ /[A-Z]/ && $3 !~ /^(_init|_fini)$/ {print $3}' | sort >shown
grep -E '^PERIGEE_API' "$root/src/perigee.h" | grep -oE 'perigee_[a-z_]+\(' | tr -d '(' | sort >promised
[[ -n $sanitize ]] || diff promised shown || fail "the library does not show what perigee.h promises"

# A world of hills: 36 x 18 samples.
{
    printf 'ncols 36\nnrows 18\nxllcorner -180\nyllcorner -90\ncellsize 10\n'
    awk 'BEGIN {for (r = 0; r < 18; r++) {for (c = 0; c < 36; c++) printf "%d ", 500 * (1 + sin(r) * cos(c)); print ""}}'
} >hills.asc
cat >hills.prj <<'WKT'
GEOGCS["WGS 84",DATUM["WGS_1984",SPHEROID["WGS 84",6378137,298.257223563]],PRIMEM["Greenwich",0],UNIT["degree",0.0174532925199433]]
WKT
try import.log "$prefix/bin/perigee" import --height hills.asc -o hills.planet

# lit_enough PROGRAM: seen from 20,000 km a planet covers a good part of the frame and sky the rest.
lit_enough() {
    local said lit
    said=$("$1" hills.planet 2>"$1.err") || { cat "$1.err"; fail "$1 does not run"; }
    echo "$1: $said"
    lit=${said%% *}
    ((lit > 640 * 480 / 20 && lit < 640 * 480)) || fail "$1: $said"
}

# The driver's modules leak 240 bytes when they are unloaded; leaks of our own are seen by the tests of render.
export ASAN_OPTIONS=detect_leaks=0${ASAN_OPTIONS:+:$ASAN_OPTIONS}
flags=${sanitize:+-fsanitize=$sanitize}
export LD_LIBRARY_PATH=$lib PKG_CONFIG_PATH=$lib/pkgconfig CFLAGS="-Wall -Wextra -Werror $flags" LDFLAGS=$flags CC=$cc
try cmake.log cmake -S "$root/examples/embed" -B by-cmake -G Ninja -DCMAKE_PREFIX_PATH="$prefix"
try ninja.log ninja -C by-cmake
lit_enough by-cmake/embed
cp -r "$root/examples/embed" by-make
try make.log make -C by-make
lit_enough by-make/embed
