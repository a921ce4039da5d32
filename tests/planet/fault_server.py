#!/usr/bin/env python3
"""A tile server on loopback that misbehaves as its paths say; prints its port, ends with its standard input.

/ok/Z/X/Y        a PNG of 256 x 256, all of it (10 Z, X & 255, Y & 255, 255)
/height/Z/X/Y    a terrarium PNG of 100 Z metres;  /rgb/Z/X/Y  the same as terrain-RGB
/slow/MS/...     the same as without, after MS milliseconds
/status/N/...    answer N;  /busy/S/N/...  429 with Retry-After S to the first N, then as without
/flaky/N/...     500 to the first N, then as without
/down/...        the connection is closed without an answer, while /control/down is set
/short/...       half of what Content-Length promises;  /huge/  40 MiB;  /endless/  up to 64 MiB of unknown length
/html/...        a page that says 200
/size/...        a PNG of 512 x 512;  /bomb/  a PNG that says 60000 x 60000;  /cut/  half a PNG, well framed
/to/SCHEME/...   a redirect to file:, ftp: or back to /ok/;  /loop/  one to itself
/tag/...         ETag and max-age=0; 304 when it is asked for by its tag;  /dated/  the same by Last-Modified
/sick/...        as /ok/, or as the kind that /control/sick/KIND (and what follows) said last; ok: healthy
/control/stats   requests by their first part, and the most at once;  /control/down/0 or 1
/control/pauses/...  milliseconds between the requests for the rest of the path, rounded up
"""
import collections
import json
import math
import struct
import sys
import threading
import time
import zlib
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer

lock = threading.Lock()
seen = collections.Counter()
tries = collections.Counter()
times = collections.defaultdict(list)
now_open = most_open = 0
down = False
sick = ["ok"]


def chunk(kind, data):
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))


def png(width, height, rgba, rows=None):
    line = b"\0" + bytes(rgba) * width
    data = zlib.compress(line * (height if rows is None else rows), 1)
    head = struct.pack(">IIBBBBB", width, height, 8, 6, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", data) + chunk(b"IEND", b"")


def tile(parts):
    z, x, y = (int(p.split(".")[0]) for p in parts[-3:])
    if "height" in parts:
        value = int((100 * z + 32768) * 256)
        return png(256, 256, (value >> 16 & 255, value >> 8 & 255, value & 255, 255))
    if "rgb" in parts:
        value = (100 * z + 10000) * 10
        return png(256, 256, (value >> 16 & 255, value >> 8 & 255, value & 255, 255))
    return png(256, 256, (10 * z & 255, x & 255, y & 255, 255))


class Handler(BaseHTTPRequestHandler):
    protocol_version = "HTTP/1.1"
    disable_nagle_algorithm = True
    wbufsize = -1

    def log_message(self, *args):
        pass

    def answer(self, code, body=b"", kind="image/png", **headers):
        self.send_response(code)
        self.send_header("Content-Type", kind)
        self.send_header("Content-Length", str(headers.pop("length", len(body))))
        for name, value in headers.items():
            self.send_header(name.replace("_", "-"), value)
        self.end_headers()
        if code != 304:
            self.wfile.write(body)

    def control(self, parts):
        global down, sick
        if parts[0] == "sick":
            sick = parts[1:]
        if parts[0] == "down":
            down = parts[1] == "1"
        if parts[0] == "pauses":
            when = times["/" + "/".join(parts[1:])]
            pauses = [math.ceil(1000 * (b - a)) for a, b in zip(when, when[1:])]
            return self.answer(200, json.dumps({"pauses": pauses}).encode(), "application/json")
        self.answer(200, json.dumps({"seen": seen, "most": most_open}).encode(), "application/json")

    def do_GET(self):
        global now_open, most_open
        parts = self.path.strip("/").split("/")
        if parts[0] == "control":
            return self.control(parts[1:])
        with lock:
            seen[parts[0]] += 1
            times[self.path].append(time.monotonic())
            now_open += 1
            most_open = max(most_open, now_open)
        try:
            self.serve(parts[0], parts[1:])
        except (BrokenPipeError, ConnectionResetError):
            self.close_connection = True
        finally:
            with lock:
                now_open -= 1

    def first_tries(self, count):
        with lock:
            tries[self.path] += 1
            return tries[self.path] <= count

    def serve(self, kind, rest):
        if kind == "sick":
            kind, rest = sick[0], sick[1:] + rest
        if kind == "slow":
            time.sleep(int(rest[0]) / 1000)
        if kind == "status":
            return self.answer(int(rest[0]))
        if kind == "busy" and self.first_tries(int(rest[1])):
            return self.answer(429, Retry_After=rest[0])
        if kind == "flaky" and self.first_tries(int(rest[0])):
            return self.answer(500)
        if kind == "down" and down:
            self.close_connection = True
            return self.connection.close()
        if kind == "short":
            self.close_connection = True
            return self.answer(200, b"x" * 1000, length=2000)
        if kind == "huge":
            return self.answer(200, bytes(40 << 20))
        if kind == "endless":
            self.close_connection = True
            self.send_response(200)
            self.end_headers()
            for _ in range(64):
                self.wfile.write(bytes(1 << 20))
            return None
        if kind == "html":
            return self.answer(200, b"<html><body>You are offline</body></html>", "text/html")
        if kind == "size":
            return self.answer(200, png(512, 512, (1, 2, 3, 255)))
        if kind == "bomb":
            return self.answer(200, png(60000, 60000, (0, 0, 0, 0), 20))
        if kind == "cut":
            whole = tile(rest)
            return self.answer(200, whole[:len(whole) // 2])
        if kind == "to":
            target = {"file": "file:///etc/hostname", "ftp": "ftp://127.0.0.1/x"}.get(rest[0])
            return self.answer(302, Location=target or "/ok/" + "/".join(rest[1:]))
        if kind == "loop":
            return self.answer(302, Location=self.path)
        if kind == "dated":
            day = "Tue, 03 Nov 2026 10:00:00 GMT"
            same = self.headers.get("If-Modified-Since") == day
            return self.answer(304 if same else 200, b"" if same else tile(rest), Last_Modified=day, Cache_Control="max-age=0")
        if kind == "tag":
            if self.headers.get("If-None-Match") == '"one"':
                return self.answer(304, ETag='"one"', Cache_Control="max-age=0")
            return self.answer(200, tile(rest), ETag='"one"', Cache_Control="max-age=0")
        self.answer(200, tile([kind] + rest))


class Server(ThreadingHTTPServer):
    daemon_threads = True
    request_queue_size = 128

    def handle_error(self, request, client_address):
        pass


server = Server(("127.0.0.1", int(sys.argv[1]) if len(sys.argv) > 1 else 0), Handler)
threading.Thread(target=server.serve_forever, daemon=True).start()
print(server.server_address[1], flush=True)
sys.stdin.read()
