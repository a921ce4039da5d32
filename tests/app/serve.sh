# What the tests with a web server share. Sourced after `work` (a folder of the test's own, the current one), `perigee`
# and `root` are set; what is served lies in $work/www. Skips the test where nginx or python3 is missing.
export PATH=$PATH:/usr/sbin
for tool in nginx python3; do
    command -v $tool >/dev/null || { echo "no $tool"; exit 77; }
done
nginx_pid= line_pid=
trap 'for pid in $nginx_pid $line_pid; do kill $pid 2>/dev/null || true; done; rm -rf "$work"' EXIT

fail() {
    echo "FAILED: $*"
    exit 1
}

# try COMMAND...: shows what it said when it fails.
try() {
    "$@" >said 2>&1 || { cat said; fail "$*"; }
}

port=$(python3 -c 'import socket; s = socket.socket(); s.bind(("127.0.0.1", 0)); print(s.getsockname()[1])')

# configure_nginx [LISTEN...]: more lines for its server.
configure_nginx() {
    cat >nginx.conf <<CONF
daemon off; pid nginx.pid; worker_processes 1; error_log error.log;
events {}
http {
    types { image/png png; image/jpeg jpg; application/json json; }
    log_format short '\$server_protocol \$status \$connection \$uri';
    access_log access.log short;
    client_body_temp_path t; proxy_temp_path t; fastcgi_temp_path t; uwsgi_temp_path t; scgi_temp_path t;
    server { listen 127.0.0.1:$port; $* root www; }
}
CONF
    ((EUID != 0)) || sed -i '1i user root;' nginx.conf
}

# await_port PORT: until somebody listens there, 10 s at most.
await_port() {
    for _ in $(seq 100); do
        if (exec 3<>"/dev/tcp/127.0.0.1/$1") 2>/dev/null; then return 0; fi
        sleep 0.1
    done
    return 1
}

start_nginx() {
    nginx -p "$work" -c nginx.conf 2>nginx.err &
    nginx_pid=$!
    await_port "$port" || { cat nginx.err; fail "nginx does not start"; }
}

stop_nginx() {
    kill "$nginx_pid"
    wait "$nginx_pid" || true
    nginx_pid=
}

# same A B BOUND: no pixel of one EXR is further than BOUND pixels from the other's.
same() {
    try "$perigee" compare -q --a "$1" --b "$2" --json compare.json
    python3 - "$3" <<'PY' || { cat compare.json; fail "$1 is not $2"; }
import json, sys
text = json.load(open("compare.json"))
row = text["frames"][0] if "frames" in text else text
flat = {}
def walk(node, at):
    if isinstance(node, dict):
        for key, value in node.items():
            walk(value, at + "." + key)
    elif isinstance(node, (int, float)):
        flat[at] = node
walk(row, "")
errors = [v for k, v in flat.items() if "eometric" in k and k.lower().endswith(("max", "maximum", "max_px", "maximum_px"))]
assert errors, sorted(flat)
assert max(errors) <= float(sys.argv[1]), errors
PY
}
