# A planet is exported, served by a real nginx on loopback and seen by a second Perigee: the same picture but for the rounding
# of heights; again from the cache on disk without a request and without a server; over a slow line that loses packets, where
# network namespaces can be had; by HTTP/2 with its certificate verified; and what is said when there is no server.
# usage: test_stream.sh ROOT PROGRAM
set -euo pipefail
root=$1 perigee=$2
work=$(mktemp -d)
chmod 755 "$work"
cd "$work"
export HOME=$work PERIGEE_DATA_DIR=$root/data
unset XDG_CACHE_HOME SSL_CERT_FILE
source "$root/tests/app/serve.sh"

python3 "$root/tests/app/make_world.py"
try "$perigee" import -q --height hills.asc inset.asc --color colour.png --attribution 'Test data' -o world.planet
try "$perigee" export -q world.planet -o www/world
[[ -s www/world/planet.json ]] || fail "no planet.json"
if "$perigee" export -q world.planet -o www/world 2>said; then fail "an export is written over"; fi
grep -q 'planet.json: exists' said || fail "an export that exists is not named"

secure=
if command -v openssl >/dev/null; then
    try openssl req -x509 -newkey rsa:2048 -nodes -keyout key.pem -out cert.pem -days 2 -subj /CN=localhost \
        -addext subjectAltName=DNS:localhost
    secure="listen 127.0.0.1:$((port + 1)) ssl http2; ssl_certificate cert.pem; ssl_certificate_key key.pem;
        location /away/ { return 302 http://127.0.0.1:$port/world/planet.json; }"
fi
configure_nginx "$secure"

camera=(--lat 46.4 --lon 11 --alt 60000 --heading 20 --pitch -35 --size 320x240)
see() {
    local out=$1
    shift
    try "$perigee" render "$@" "${camera[@]}" -o "$out"
}

url=http://127.0.0.1:$port/world/planet.json
start_nginx
see file.exr world.planet
see served.exr "$url"
grep -q 'Test data' said || fail "the attribution is lost"
same served.exr file.exr 0.001
bad=$(grep -cv ' 200 ' access.log || true)
((bad == 0)) || { grep -v ' 200 ' access.log | head; fail "$bad requests for what is not there"; }
requests=$(wc -l <access.log)
((requests > 20)) || fail "only $requests requests"

see cached.exr "$url"
(($(wc -l <access.log) == requests)) || fail "what is on disk was asked for again"
cmp served.exr cached.exr || fail "the cache shows another picture"
stop_nginx
see dead.exr "$url"
cmp served.exr dead.exr || fail "without its server the cache shows another picture"
if "$perigee" render "$url" --tile-cache none "${camera[@]}" -o x.exr 2>said; then fail "no server, no error"; fi
grep -q 'does not answer' said || { cat said; fail "a server that is down is not told"; }

# A template contacts nobody before a tile is wanted: the flight goes on over bare ground.
tiles="http://127.0.0.1:$port/world/height/{z}/{y}/{x}.png,height"
see over.exr world.planet --layer "$tiles" --tile-cache none
grep -q 'going on without it' said || { cat said; fail "a server that is down is not told"; }

start_nginx
if [[ -n $secure ]]; then
    : >access.log
    safe=https://localhost:$((port + 1))/world/planet.json
    if "$perigee" render "$safe" --tile-cache none "${camera[@]}" -o x.exr 2>said; then fail "any certificate will do"; fi
    grep -qi 'certificate' said || { cat said; fail "a wrong certificate is not named"; }
    if SSL_CERT_FILE=$work/cert.pem "$perigee" render "${safe/localhost/127.0.0.1}" --tile-cache none "${camera[@]}" \
        -o x.exr 2>said; then fail "the certificate of another host will do"; fi
    grep -q 'subject name' said || { cat said; fail "the certificate of another host is not named"; }
    SSL_CERT_FILE=$work/cert.pem see secure.exr "$safe" --tile-cache none
    cmp served.exr secure.exr || fail "https shows another picture"
    (($(grep -c '^HTTP/2' access.log) == $(wc -l <access.log))) || fail "not all by HTTP/2"
    connections=$(awk '{print $3}' access.log | sort -u | wc -l)
    echo "$(wc -l <access.log) tiles by HTTP/2 over $connections connection(s)"
    ((connections <= 3)) || fail "HTTP/2 is not multiplexed"
    # What was asked for in secret is not had in the open, though http may send elsewhere.
    away() {
        : >access.log
        SSL_CERT_FILE=$work/cert.pem "$perigee" render "$1/away/planet.json" --tile-cache none "${camera[@]}" -o x.exr 2>said || true
    }
    away "https://localhost:$((port + 1))"
    grep -q '^perigee: error: https://localhost' said || { cat said; fail "a redirect to http is not told"; }
    if grep -q '/world/' access.log; then fail "https is left for http"; fi
    away "http://127.0.0.1:$port"
    grep -q '/world/planet.json' access.log || { cat said access.log; fail "no redirect is followed"; }
fi
stop_nginx

# The server goes away in mid-flight: the flight goes on.
mkdir frames
start_nginx
"$perigee" fly "$url" --tile-cache none --path "$root/data/flights/orbit-to-garda.json" --fps 1 --size 160x120 \
    -o frames/%03d.png >said 2>&1 &
flight=$!
for _ in $(seq 300); do [[ -e frames/004.png ]] && break || sleep 0.1; done
stop_nginx
wait $flight || { cat said; fail "a flight ends with its server"; }
grep -q 'going on without it' said || { cat said; fail "a server that went away is not told"; }
seconds=$(python3 -c "import json; print(int(json.load(open('$root/data/flights/orbit-to-garda.json'))['keys'][-1]['time']))")
(($(find frames -name '*.png' | wc -l) >= seconds)) || fail "frames are missing"

# 25 ms each way, and one piece of 16 KiB in 20 is cut off together with its connection.
start_nginx
python3 "$root/tests/app/slow_line.py" $((port + 2)) "$port" 25 20 >line.log 2>&1 &
line_pid=$!
await_port $((port + 2)) || { cat line.log; fail "the slow line does not start"; }
slow_url=http://127.0.0.1:$((port + 2))/world/planet.json
see slow.exr "$slow_url" --tile-cache none
cat >down.json <<'JSON'
{"name": "Down to the inset", "fov": 60, "keys": [
    {"time": 0, "lat": 45, "lon": 10, "alt": 3000000, "heading": 0, "pitch": -90},
    {"time": 2, "lat": 46.2, "lon": 10.9, "alt": 200000, "heading": 10, "pitch": -60},
    {"time": 4, "lat": 46.6, "lon": 11.1, "alt": 40000, "heading": 30, "pitch": -30}]}
JSON
mkdir quick slowly
for way in "quick $url" "slowly $slow_url"; do
    read -r folder source <<<"$way"
    try "$perigee" fly "$source" --tile-cache none --path down.json --fps 1 --size 160x120 -o "$folder/%03d.png"
done
for frame in quick/*.png; do cmp "$frame" "slowly/${frame##*/}" || fail "a slow line shows another flight"; done
(($(find slowly -name '*.png' | wc -l) >= 5)) || fail "frames of the slow flight are missing"
kill $line_pid
wait $line_pid || true
cmp served.exr slow.exr || fail "a slow line that loses connections shows another picture"
grep -q 'pieces, [1-9][0-9]* connections cut' line.log || { cat line.log; fail "nothing was lost"; }
echo "the same picture and flight over 25 ms each way: $(cat line.log)"
stop_nginx

# The same by lost packets, where the kernel can: 25 ms each way and 2 % of them.
slow() {
    export -f start_nginx await_port fail
    export work port perigee url
    unshare -n bash -c '
        set -e
        ip link set lo up
        tc qdisc add dev lo root netem delay 25ms loss 2% || exit 77
        start_nginx
        "$perigee" render "$url" --tile-cache none "$@" -o slow.exr || { kill $nginx_pid; exit 1; }
        kill $nginx_pid' slow "${camera[@]}"
}
status=0
slow >said 2>&1 || status=$?
case $status in
0)
    cmp served.exr slow.exr || fail "a slow line shows another picture"
    echo "the same picture over 25 ms each way with 2 % loss"
    ;;
*)
    grep -qE 'unshare|qdisc|RTNETLINK|not found|not permitted' said || { cat said; fail "over a slow line"; }
    echo "no slow line here (network namespaces and netem are needed)"
    ;;
esac
