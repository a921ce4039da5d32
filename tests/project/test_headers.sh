# Every header compiles alone, without warnings, as C17; the public one as C++ and strict C too.
set -euo pipefail
root=$1 cc=$2 cxx=$3
failed=0

# alone HEADER COMPILER...
alone() {
    local header=$1
    shift
    if ! "$@" -Wall -Wextra -Werror -Wno-unused-function -fsyntax-only -I"$root/src" -I"$root/shaders" "$header"; then
        echo "$header does not compile alone"
        failed=1
    fi
}

while IFS= read -r header; do
    alone "$header" "$cc" -std=c17 -D_GNU_SOURCE -x c
done < <(find "$root/src" -name '*.h' | sort)
alone "$root/src/perigee.h" "$cc" -std=c99 -pedantic -x c
alone "$root/src/perigee.h" "$cxx" -std=c++11 -pedantic -x c++
exit $failed
