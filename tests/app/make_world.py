#!/usr/bin/env python3
"""Writes a small world beside itself: hills.asc (0.5 degrees), inset.asc (0.02 degrees, 8 to 14 E, 44 to 49 N) and colour.png."""
import math
import struct
import sys
import zlib

WKT = ('GEOGCS["WGS 84",DATUM["WGS_1984",SPHEROID["WGS 84",6378137,298.257223563]],PRIMEM["Greenwich",0],'
       'UNIT["degree",0.0174532925199433]]')


def height(lat, lon):
    lat, lon = math.radians(lat), math.radians(lon)
    return 1500 + 900 * math.sin(3 * lat) * math.cos(2 * lon) + 500 * math.sin(120 * lat) * math.cos(150 * lon)


def grid(name, west, south, step, cols, rows):
    with open(name + ".asc", "w") as f:
        f.write(f"ncols {cols}\nnrows {rows}\nxllcorner {west}\nyllcorner {south}\ncellsize {step}\n")
        for r in range(rows):
            lat = south + (rows - r - 0.5) * step
            f.write(" ".join(f"{height(lat, west + (c + 0.5) * step):.2f}" for c in range(cols)) + "\n")
    open(name + ".prj", "w").write(WKT)


def chunk(kind, data):
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))


def picture(name, cols, rows):
    data = b""
    for r in range(rows):
        line = bytearray(1)
        for c in range(cols):
            line += bytes((60 + 190 * c // cols, 60 + 190 * r // rows, 120 + 60 * (c // 20 + r // 20 & 1)))
        data += bytes(line)
    head = struct.pack(">IIBBBBB", cols, rows, 8, 2, 0, 0, 0)
    open(name + ".png", "wb").write(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) +
                                    chunk(b"IDAT", zlib.compress(data)) + chunk(b"IEND", b""))
    open(name + ".png.aux.xml", "w").write(
        f"<PAMDataset><SRS>{WKT}</SRS><GeoTransform>-180, {360 / cols}, 0, 90, 0, {-180 / rows}"
        "</GeoTransform></PAMDataset>")


grid("hills", -180, -90, 0.5, 720, 360)
grid("inset", 8, 44, 0.02, 300, 250)
picture("colour", 720, 360)
sys.exit(0)
