# Every C and C++ file is as clang-format leaves it. Its output differs between versions: the house's is 14.
set -euo pipefail
root=$1
formatter=$(command -v clang-format-14 || command -v clang-format) || { echo "no clang-format"; exit 77; }
version=$("$formatter" --version)
[[ $version == *"version 14."* ]] || { echo "clang-format 14 is wanted, here is $version"; exit 77; }
find "$root"/src "$root"/tests "$root"/bench "$root"/examples \( -name '*.[ch]' -o -name '*.cpp' \) -print0 |
    xargs -0 "$formatter" --dry-run --Werror --ferror-limit=3
