# Every shell script passes bash -n and, where it is installed, shellcheck.
set -euo pipefail
cd "$1"
mapfile -t scripts < <(ls run test .ci/run scripts/setup.sh scripts/format tests/project/*.sh)
for script in "${scripts[@]}"; do bash -n "$script"; done
command -v shellcheck >/dev/null || { echo "no shellcheck"; exit 77; }
shellcheck -s bash -x "${scripts[@]}"
