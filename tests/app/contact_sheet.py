#!/usr/bin/env python3
"""contact_sheet.py OUT.png COLUMNS PICTURE.png...: pictures of one size (8-bit RGB) side by side; fails on a black or even one."""
import struct
import sys
import zlib


def read(path):
    data = open(path, "rb").read()
    at, body, size = 8, b"", None
    while at < len(data):
        length, kind = struct.unpack(">I4s", data[at:at + 8])
        chunk = data[at + 8:at + 8 + length]
        if kind == b"IHDR":
            size = struct.unpack(">IIBBBBB", chunk)
        if kind == b"IDAT":
            body += chunk
        at += 12 + length
    width, height = size[:2]
    assert size[2:] == (8, 2, 0, 0, 0), (path, size)
    raw, rows, above = zlib.decompress(body), [], bytearray(3 * width)
    for y in range(height):
        kind = raw[y * (3 * width + 1)]
        row = bytearray(raw[y * (3 * width + 1) + 1:(y + 1) * (3 * width + 1)])
        for i in range(len(row)):
            left = row[i - 3] if i >= 3 else 0
            corner = above[i - 3] if i >= 3 else 0
            up = above[i]
            if kind == 1:
                row[i] = row[i] + left & 255
            elif kind == 2:
                row[i] = row[i] + up & 255
            elif kind == 3:
                row[i] = row[i] + (left + up) // 2 & 255
            elif kind == 4:
                p = left + up - corner
                a, b, c = abs(p - left), abs(p - up), abs(p - corner)
                row[i] = row[i] + (left if a <= b and a <= c else up if b <= c else corner) & 255
        rows.append(row)
        above = row
    return rows


def chunk(kind, data):
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))


pictures = [read(p) for p in sys.argv[3:]]
columns, height, width = int(sys.argv[2]), len(pictures[0]), len(pictures[0][0]) // 3
for name, rows in zip(sys.argv[3:], pictures):
    assert len({bytes(row) for row in rows}) > height // 2, name + ": all of one colour"
lines = []
for first in range(0, len(pictures), columns):
    group = pictures[first:first + columns]
    for y in range(height):
        line = b"".join(bytes(p[y]) for p in group)
        lines.append(b"\0" + line + bytes(3 * width * columns - len(line)))
head = struct.pack(">IIBBBBB", width * columns, len(lines), 8, 2, 0, 0, 0)
with open(sys.argv[1], "wb") as out:
    out.write(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(b"".join(lines), 6)) + chunk(b"IEND", b""))
