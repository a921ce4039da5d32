# The arrows between the rooms hold: what each room includes and what its CMakeLists.txt links, and which third-party
# headers it may see. No loop waits for GL's last error. Also proves itself: a forbidden include in a copy of a room must be found.
set -euo pipefail
root=$1

# room: the rooms it may use
declare -A arrows=(
    [base]=""
    [geo]="base"
    [planet]="geo base"
    [clipmap]="planet geo base"
    [gpu]="base"
    [render]="clipmap planet gpu geo base"
    [reference]="planet geo base"
    [app]="reference render clipmap planet gpu geo base"
)

# header pattern: the rooms whose .c and .cpp files may include it
third_party=(
    '^(geodesic|proj)\.h$|^libnova/ geo'
    '^(gdal|ogr|cpl)_[a-z_]+\.h$|^gdal\.h$|^gdalwarper\.h$ planet'
    '^sqlite3\.h$ planet'
    '^openexr.*\.h$|^OpenEXR/ planet app'
    '^turbojpeg\.h$ planet'
    '^(zstd|openjpeg|libaec|xxhash)\.h$ planet'
    '^epoxy/|^EGL/|^GL/|^KHR/ gpu render'
    '^GLFW/|^imgui|^backends/imgui_ app'
    '^mpi\.h$ app'
    '^GeographicLib/ reference'
    '^png\.h$|^cjson/ planet app'
    '^curl/|^webp/ planet'
)

standard='^(assert|complex|ctype|endian|errno|fcntl|fenv|float|getopt|glob|inttypes|langinfo|libgen|limits|locale|malloc|math'
standard+='|poll|pthread|sched|semaphore|setjmp|signal|spawn|stdalign|stdarg|stdatomic|stdbool|stddef|stdint|stdio'
standard+='|stdlib|stdnoreturn|string|strings|tgmath|threads|time|unistd|wchar'
standard+='|sys/[a-z]+|dirent|dlfcn|algorithm|cstddef|cstdint|cstdio|cstdlib|cstring|cmath)(\.h)?$'

# allowed_external ROOM FILE HEADER
allowed_external() {
    local entry pattern room
    [[ ! $3 =~ $standard ]] || return 0
    # In headers: GL's own types, the contract of gpu and render; and in app, whose headers nobody else reads.
    [[ $2 != *.h || $3 == epoxy/gl.h || $1 == app ]] || return 1
    for entry in "${third_party[@]}"; do
        pattern=${entry%% *}
        [[ $3 =~ $pattern ]] || continue
        for room in ${entry#* }; do [[ $room != "$1" ]] || return 0; done
    done
    return 1
}

# allowed_local ROOM HEADER
allowed_local() {
    local room
    # The judge shares no arithmetic with what it judges: of geo the body's two axes, of planet the samples.
    if [[ $1 == reference ]]; then
        case $2 in
        base/* | reference/* | geo/ellipsoid.h | planet/pyramid.h) return 0 ;;
        */*) return 1 ;;
        esac
    fi
    case $2 in
    perigee.h) [[ $1 == render || $1 == app ]] && return 0 || return 1 ;;
    shared/*) return 0 ;;
    render/*) [[ $1 == render ]] && return 0 || return 1 ;; # app links it and sees perigee.h
    */*) ;;
    *) return 0 ;;
    esac
    for room in "$1" ${arrows[$1]}; do [[ ${2%%/*} != "$room" ]] || return 0; done
    return 1
}

# scan SRC: prints every include that goes against an arrow.
scan() {
    local room file line header kind
    for room in "${!arrows[@]}"; do
        [[ -d $1/$room ]] || continue
        while IFS=: read -r file line; do
            [[ $line =~ include[[:space:]]*([\"\<])([^\"\>]+)[\"\>] ]] || continue
            kind=${BASH_REMATCH[1]} header=${BASH_REMATCH[2]}
            if [[ $kind == '"' ]]; then
                allowed_local "$room" "$header" || echo "$file: \"$header\" is not for room $room"
            else
                allowed_external "$room" "$file" "$header" || echo "$file: <$header> may not be in it"
            fi
        done < <(grep -rE '^[[:space:]]*#[[:space:]]*include' "$1/$room" \
            --include='*.[ch]' --include='*.cpp' --include='*.inc')
    done
}

# scan_calls SRC: prints every conversion of geo that the reference calls; geo_is_plane only asks what a body is.
scan_calls() {
    grep -rnoE '\bgeo_[a-z_]+ *\(' "$1/reference" --include='*.[ch]' --include='*.cpp' | grep -v 'geo_is_plane *(' |
        sed 's/$/ is not for room reference/' || true
}

# scan_loops SRC: prints every loop that waits for the last GL error, of which a lost context has none; gpu_context_forgive knows how.
scan_loops() {
    grep -rnE '(while|for) *\(.*glGetError' "$1" --include='*.[ch]' --include='*.cpp' | grep -v '/gpu/context\.c:' |
        sed 's/$/   <- a loop over errors/' || true
}

# scan_links SRC: prints every room linked against an arrow.
scan_links() {
    local room used other
    for room in "${!arrows[@]}"; do
        [[ -e $1/$room/CMakeLists.txt ]] || continue
        while IFS= read -r used; do
            for other in ${arrows[$room]}; do [[ $other != "$used" ]] || continue 2; done
            echo "$1/$room/CMakeLists.txt: room $room may not link $used"
        done < <(sed -nE 's/^perigee_room\(([^)]*)\).*/\1/p' "$1/$room/CMakeLists.txt" | tr ' ' '\n' | tail -n +2)
    done
}

copy=$(mktemp -d)
trap 'rm -rf "$copy"' EXIT
mkdir -p "$copy/geo" "$copy/reference"
printf '#include "geo/frames.h"\n#include "shared/position.glsl"\n#include "planet/pyramid.h"\n' >"$copy/reference/wrong.c"
printf 'while (glGetError()) {}\n' >"$copy/geo/loop.c"
printf 'bool p = geo_is_plane(e);\ndvec3 x = geo_ecef_from_geodetic(e, g);\n' >>"$copy/reference/wrong.c"
printf '#include <math.h>\n#include "planet/grid.h"\n#include <sqlite3.h>\n' >"$copy/geo/wrong.c"
printf '#include <geodesic.h>\n' >"$copy/geo/wrong.h"
printf 'perigee_room(geo base gpu)\n' >"$copy/geo/CMakeLists.txt"
if (($(scan "$copy" | wc -l) != 5)) || (($(scan_calls "$copy" | wc -l) != 1)) || (($(scan_links "$copy" | wc -l) != 1)) ||
    (($(scan_loops "$copy" | wc -l) != 1)); then
    echo "the scan itself is broken: it does not find the planted faults"
    scan "$copy"
    scan_calls "$copy"
    scan_links "$copy"
    scan_loops "$copy"
    exit 1
fi

faults=$(scan "$root/src"; scan_calls "$root/src"; scan_links "$root/src"; scan_loops "$root/src")
[[ -z $faults ]] || { echo "$faults"; exit 1; }
