# An import by several processes gives the same file as by one, byte by byte; also when all of them are killed on the way and
# others go on. With network namespaces, which need rights, the processes stand on two hosts that share a folder.
# Also of heights within a bound. Colour lies beside the heights in every one.
#   usage: test_mpi.sh PERIGEE MPIRUN
set -euo pipefail
perigee=$1 mpirun=$2
[[ -x $mpirun ]] || { echo "no mpirun"; exit 77; }
dir=$(mktemp -d)
cleanup() {
    for name in pgA$$ pgB$$; do ip netns del "$name" 2>/dev/null || true; done
    rm -rf "$dir"
}
trap cleanup EXIT
export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 OMPI_MCA_btl_base_warn_component_unused=0
launch=("$mpirun" --oversubscribe --bind-to none)

# A rough globe of 2048 x 1024 samples (zoom 2) and an inset of zoom 5, in a format of plain text.
grid() { # FILE COLUMNS ROWS WEST SOUTH CELL
    awk -v c="$2" -v r="$3" -v w="$4" -v s="$5" -v d="$6" 'BEGIN {
        printf "ncols %d\nnrows %d\nxllcorner %.9g\nyllcorner %.9g\ncellsize %.17g\n", c, r, w, s, d
        for (y = 0; y < r; y++) { line = ""
            for (x = 0; x < c; x++) { lon = w + x * d; lat = s + (r - y) * d
                line = line sprintf("%.1f ", 500 * sin(lon * 0.31) * cos(lat * 0.23) + 90 * sin(lon * 7.1 + lat * 5.3)) }
            print line } }' >"$1"
    echo 'GEOGCS["WGS 84",DATUM["WGS_1984",SPHEROID["WGS 84",6378137,298.257223563]],PRIMEM["Greenwich",0],UNIT["degree",0.0174532925199433]]' >"${1%.asc}.prj"
}
grid "$dir/globe.asc" 2048 1024 -180 -90 0.17578125
grid "$dir/inset.asc" 600 600 5 40 0.02
python3 - "$dir/colour" <<'COLOUR'
import sys
cols, rows = 1440, 720
with open(sys.argv[1] + ".ppm", "wb") as f:
    f.write(b"P6\n%d %d\n255\n" % (cols, rows))
    for y in range(rows):
        f.write(bytes(v for x in range(cols) for v in ((x * 7 + y) & 255, (x ^ y) & 255, (x * y >> 6) & 255)))
srs = open(sys.argv[1].replace("colour", "globe") + ".prj").read()
open(sys.argv[1] + ".wld", "w").write("0.25 0 0 -0.25 -179.875 89.875".replace(" ", "\n") + "\n")
open(sys.argv[1] + ".ppm.aux.xml", "w").write(f"<PAMDataset><SRS>{srs}</SRS></PAMDataset>")
COLOUR
sources=(--height "$dir/globe.asc" "$dir/inset.asc" --color "$dir/colour.ppm")
mkdir "$dir"/{one,two,killed,hosts}
"$perigee" import -q "${sources[@]}" -o "$dir/one/x.planet"
"$perigee" info "$dir/one/x.planet" | grep -q 'color .* tiles' || { echo "no colour"; exit 1; }

"${launch[@]}" -n 2 "$perigee" import -v "${sources[@]}" -o "$dir/two/x.planet" 2>"$dir/log" || { cat "$dir/log"; exit 1; }
cmp "$dir/one/x.planet" "$dir/two/x.planet"
echo "two processes: the same $(stat -c %s "$dir/two/x.planet") bytes; $(grep complete "$dir/log")"
for rank in 0 1; do grep -q "process $rank of 2 made [1-9]" "$dir/log" || { cat "$dir/log"; exit 1; }; done
[[ $(ls "$dir/two") == x.planet ]] || { ls "$dir/two"; exit 1; }

# Within a bound, where rank 0 alone codes heights as it joins what all have made.
bounded=(--codec bounded --max-error 4)
mkdir "$dir"/{bounded1,bounded3}
"$perigee" import -q "${sources[@]}" "${bounded[@]}" -o "$dir/bounded1/x.planet"
"${launch[@]}" -n 3 "$perigee" import -q "${sources[@]}" "${bounded[@]}" -o "$dir/bounded3/x.planet"
cmp "$dir/bounded1/x.planet" "$dir/bounded3/x.planet"
sizes=("$(stat -c %s "$dir/one/x.planet")" "$(stat -c %s "$dir/bounded1/x.planet")")
((sizes[1] < sizes[0])) || { echo "within a bound it is not smaller: ${sizes[*]}"; exit 1; }
echo "three processes, heights within 4 m: the same ${sizes[1]} bytes of ${sizes[0]}"

kills=0
for s in 0.5 0.7 0.9; do
    "${launch[@]}" -n 2 "$perigee" import -q --resume "${sources[@]}" -o "$dir/killed/x.planet" >"$dir/log" 2>&1 &
    pid=$!
    sleep "$s"
    mapfile -t ranks < <(pgrep -P "$pid" || true)
    [[ -e $dir/killed/x.planet ]] || kills=$((kills + 1))
    kill -9 "$pid" "${ranks[@]}" 2>/dev/null || true
    wait "$pid" 2>/dev/null || true
done
if [[ ! -e $dir/killed/x.planet ]]; then
    "${launch[@]}" -n 3 "$perigee" import -q --resume "${sources[@]}" -o "$dir/killed/x.planet"
fi
cmp "$dir/one/x.planet" "$dir/killed/x.planet"
echo "killed $kills times, gone on with by three: the same bytes"

if ! ip netns add pgA$$ 2>/dev/null || ! ip netns add pgB$$ 2>/dev/null ||
    ! ip link add vA$$ netns pgA$$ type veth peer name vB$$ netns pgB$$ 2>/dev/null; then
    echo "skipped: no right to make network namespaces"
    exit 0
fi
for side in "pgA$$ vA$$ 10.77.0.1" "pgB$$ vB$$ 10.77.0.2"; do
    read -r space link address <<<"$side"
    ip -n "$space" addr add "$address/24" dev "$link"
    ip -n "$space" link set "$link" up
    ip -n "$space" link set lo up
done
cat >"$dir/agent" <<AGENT
#!/bin/sh
shift
exec ip netns exec pgB$$ unshare -u sh -c "hostname pgb; \$*"
AGENT
chmod +x "$dir/agent"
net=10.77.0.0/24
ip netns exec pgA$$ unshare -u sh -c 'hostname pga; exec "$@"' sh timeout 120 "${launch[@]}" -H 10.77.0.1:1,10.77.0.2:1 -n 2 \
    --mca plm_rsh_agent "$dir/agent" --mca btl tcp,self --mca btl_tcp_if_include $net --mca oob_tcp_if_include $net \
    "$perigee" import "${sources[@]}" -o "$dir/hosts/x.planet" 2>"$dir/log" || { cat "$dir/log"; exit 1; }
cmp "$dir/one/x.planet" "$dir/hosts/x.planet"
echo "two hosts: the same bytes; $(grep complete "$dir/log")"
