# Habits of the files: none past 600 lines, no machine's own paths, no unfinished business, no space at line ends.
set -euo pipefail
root=$1
cd "$root"

sources() {
    find . \( -path ./.git -o -path './build*' -o -path ./frames -o -path ./out -o -path ./data \) -prune -o -type f \
        \( -name '*.[ch]' -o -name '*.cpp' -o -name '*.inc' -o -name '*.glsl' -o -name '*.vert' -o -name '*.frag' \
        -o -name '*.comp' -o -name '*.sh' -o -name '*.py' -o -name '*.cmake' -o -name '*.in' -o -name '*.md' -o -name 'CMakeLists.txt' \
        -o -name '*.json' -o -name '*.1' -o -path ./run -o -path ./test -o -path './.ci/*' \) -print | sort
}

mapfile -t files < <(sources)
((${#files[@]} > 20)) || { echo "only ${#files[@]} files found: the search is broken"; exit 1; }

faults=$(
    for file in "${files[@]}"; do
        lines=$(wc -l <"$file")
        ((lines <= 600)) || echo "$file: $lines lines, past 600"
    done
    # The brackets keep these lines from finding themselves.
    grep -nHE '(^|[^A-Za-z0-9_.$}])/(wor[k]|roo[t]|hom[e]|User[s])/[A-Za-z]' "${files[@]}" | sed 's/$/   <- a path of one machine/'
    grep -nHE '(^|[^A-Za-z0-9_.$}])/tm[p]/' "${files[@]}" | sed 's/$/   <- a path of one machine/'
    grep -nHwE 'TOD[O]|FIXM[E]|XX[X]|HAC[K]' "${files[@]}" | sed 's/$/   <- unfinished/'
    grep -nHE '[[:space:]]+$' "${files[@]}" | sed 's/$/   <- space at the end of the line/'
) || true
[[ -z $faults ]] || { echo "$faults"; exit 1; }
