#!/usr/bin/env bash
# The ways to place vertices side by side: error against the reference, triangles and GPU memory in the views of error_views.h,
# as CSV. Each mode by its defaults. Errors are in pixels of the size given.
#   usage: compare_modes.sh PERIGEE PLANET [WIDTHxHEIGHT]
set -euo pipefail
perigee=$1 planet=$2 size=${3:-320x240}
views=$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")/error_views.h
dir=$(mktemp -d)
trap 'rm -rf "$dir"' EXIT
column() { # CSV-FILE NAME: the last row's value
    awk -F, -v name="$2" 'NR == 1 { for (i = 1; i <= NF; i++) if ($i == name) at = i } END { print $at }' "$1"
}
member() { # JSON-LINE NAME
    sed -E "s/.*\"$2\":([^,}]*).*/\1/" "$1"
}
echo "view,mode,rms_px,rank_999_px,max_px,rank_999_with_silhouettes_px,missing_inside,ground_px,triangles,gpu_mib"
sed -nE 's/^ *\{"([^"]*)", (.*)\},$/\1|\2/p' "$views" | while IFS='|' read -r name numbers; do
    IFS=', ' read -r lat lon above heading pitch fov <<<"$numbers"
    camera=(--no-synthesis --lat "$lat" --lon "$lon" --above-ground "$above" --heading "$heading" --pitch "$pitch" --fov "$fov" --size "$size")
    "$perigee" render "$planet" --mode reference --zoom-error 0.2 "${camera[@]}" -q -o "$dir/truth.exr"
    for mode in spherical planar grid; do
        "$perigee" compare "$planet" --a "$mode" --b "$dir/truth.exr" --no-synthesis -q --csv "$dir/errors" >/dev/null 2>"$dir/log" || { cat "$dir/log" >&2; exit 1; }
        "$perigee" render "$planet" --mode "$mode" "${camera[@]}" -q --stats "$dir/stats" -o "$dir/picture.png" 2>>"$dir/log"
        echo "\"$name\",$mode,$(column "$dir/errors" geometric_px_rms),$(column "$dir/errors" geometric_px_p999),$(column "$dir/errors" geometric_px_max),$(column "$dir/errors" geometric_all_px_p999),$(column "$dir/errors" missing_inside),$(column "$dir/errors" ground),$(member "$dir/stats" triangles_drawn),$(awk -v b="$(member "$dir/stats" gpu_bytes)" 'BEGIN { printf "%.1f", b / 1048576 }')"
    done
done
