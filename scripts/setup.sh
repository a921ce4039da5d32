# Sourced by ./run and ./test: packages, build, default Earth, each only when it is needed.
# Messages go to standard error; logs to the build folder. Needs $root, the top of the source tree.
: "${root:?}"

say() {
    printf 'perigee: %s\n' "$*" >&2
}

die() {
    say "error: $*"
    exit 1
}

# run_logged LOG WHAT COMMAND...: quiet unless the command fails, then the end of its log.
run_logged() {
    local log=$1 what=$2
    shift 2
    if ! "$@" >>"$log" 2>&1 </dev/null; then
        tail -n 60 "$log" >&2
        die "$what failed; the whole log is $log"
    fi
}

# package_names FILE...: the names, without comments.
package_names() {
    sed -e 's/[[:space:]]*#.*//' -e '/^[[:space:]]*$/d' "$@"
}

missing_packages() {
    local name
    for name in "$@"; do
        dpkg-query -W -f='${db:Status-Status}\n' "$name" 2>/dev/null | grep -qx installed ||
            printf '%s\n' "$name"
    done
}

# install_packages LOG NAME...
install_packages() {
    local log=$1
    shift
    local -a as_root=(env DEBIAN_FRONTEND=noninteractive)
    local -a options=(-y -q -o Dpkg::Use-Pty=0 -o DPkg::Lock::Timeout=300)
    if ((EUID != 0)); then
        command -v sudo >/dev/null ||
            die "these packages are missing, and neither root nor sudo is there to install them: $*"
        say "sudo is needed to install $# packages: $*"
        sudo -v || die "without sudo these packages cannot be installed: $*"
        as_root=(sudo "${as_root[@]}")
    fi
    say "installing $# packages (log: $log): $*"
    run_logged "$log" "apt-get update" "${as_root[@]}" apt-get "${options[@]}" update
    run_logged "$log" "apt-get install $*" \
        "${as_root[@]}" apt-get "${options[@]}" install --no-install-recommends "$@"
}

# ensure_packages BUILD FILE...: checked once for each content of the lists.
ensure_packages() {
    local build=$1 stamp
    shift
    [[ -z ${PERIGEE_NO_INSTALL:-} ]] || return 0
    stamp=$build/packages-$(cat "$@" | cksum | tr ' ' -)
    [[ ! -e $stamp ]] || return 0
    local -a names missing
    mapfile -t names < <(package_names "$@")
    if ! command -v apt-get >/dev/null || ! command -v dpkg-query >/dev/null; then
        die "only Debian and Ubuntu packages are known here, and there is no apt-get;" \
            "install the equivalents of: ${names[*]}; then set PERIGEE_NO_INSTALL=1"
    fi
    mapfile -t missing < <(missing_packages "${names[@]}")
    ((${#missing[@]} == 0)) || install_packages "$build/packages.log" "${missing[@]}"
    : >"$stamp"
}

# show_steps: ninja's "[3/40] ..." lines as one line that counts, where a terminal shows it.
show_steps() {
    local line
    while IFS= read -r line; do
        [[ ! -t 2 || ! $line =~ ^\[[0-9]+/[0-9]+\] ]] ||
            printf '\rperigee: building %s ' "${BASH_REMATCH[0]}" >&2
    done
    [[ ! -t 2 ]] || printf '\r\033[K' >&2
}

# ensure_build BUILD GOAL TARGET CMAKE_OPTION...: builds when a source is newer than the last success for GOAL
# (a stamp; ninja itself would take longer to say so). Building everything covers the goal "program".
ensure_build() {
    local build=$1 goal=$2 target=$3 stamp=$1/built-$2 log=$1/build.log
    shift 3
    local -a inputs=()
    local input
    for input in CMakeLists.txt CMakePresets.json bench cmake data doc examples scripts shaders src tests; do
        [[ ! -e $root/$input ]] || inputs+=("$root/$input")
    done
    if [[ -e $stamp && -z $(find "${inputs[@]}" -newer "$stamp" -print -quit) ]]; then return 0; fi
    say "building $goal (log: $log)"
    : >"$stamp.begun"
    : >"$log"
    run_logged "$log" "configuring" cmake -S "$root" -B "$build" -G Ninja "$@"
    if ! ninja -C "$build" "$target" </dev/null 2>&1 | tee -a "$log" | show_steps; then
        tail -n 60 "$log" >&2
        die "the build failed; the whole log is $log"
    fi
    mv "$stamp.begun" "$stamp"
    [[ $target != all ]] || cp -p "$stamp" "$build/built-program"
}

# ensure_earth PROGRAM: the default Earth, where the program looks for it, made before the first start.
ensure_earth() {
    local earth data=${XDG_DATA_HOME:-}
    [[ $data == /* ]] || data=${HOME:-}/.local/share
    earth=${PERIGEE_EARTH:-$data/perigee/earth.planet}
    [[ ! -e $earth ]] || return 0
    say "making the default Earth, once: $earth"
    "$1" import --earth >&2 </dev/null || die "the default Earth could not be made"
}

# lock_build BUILD: one set-up at a time; unlock_build before the program starts.
lock_build() {
    mkdir -p "$1" || die "cannot make the build folder $1"
    exec 9>"$1/setup.lock"
    if ! flock -n 9; then
        say "waiting for another set-up of $1"
        flock 9
    fi
}

unlock_build() {
    exec 9>&-
}
