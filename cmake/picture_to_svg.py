#!/usr/bin/env python3
"""Turns a PNG of accel-trace into a small SVG of runs of equal colour, so that the README's picture is text.

usage: picture_to_svg.py IN.png OUT.svg [SHRINK]    (8-bit RGB; every SHRINK x SHRINK pixels become one)
"""
import struct
import sys
import zlib


def read_png(path):
    data, at, packed = open(path, "rb").read(), 8, b""
    while at < len(data):
        length, kind = struct.unpack(">I4s", data[at:at + 8])
        body = data[at + 8:at + 8 + length]
        if kind == b"IHDR":
            width, height, depth, color = struct.unpack(">IIBB", body[:10])
            assert (depth, color) == (8, 2), "not an 8-bit RGB picture"
        elif kind == b"IDAT":
            packed += body
        at += 12 + length
    return width, height, unfilter(zlib.decompress(packed), width, height)


def unfilter(raw, width, height):
    """Undoes the PNG filters: a list of rows of bytes."""
    rows, previous, stride = [], bytearray(3 * width), 3 * width + 1
    for y in range(height):
        kind, row = raw[y * stride], bytearray(raw[y * stride + 1:(y + 1) * stride])
        for i in range(len(row)):
            left, up = row[i - 3] if i >= 3 else 0, previous[i]
            corner = previous[i - 3] if i >= 3 else 0
            paeth = min((left, up, corner), key=lambda c: abs(left + up - corner - c))
            row[i] = (row[i] + (0, left, up, (left + up) // 2, paeth)[kind]) & 255
        rows.append(row)
        previous = row
    return rows


def shrink(width, height, rows, n):
    """Means of n x n pixels, in 16 levels."""
    def pixel(x, y):
        sums = [sum(rows[y * n + j][3 * (x * n + i) + c] for j in range(n) for i in range(n)) for c in range(3)]
        return "".join("%x" % min(15, round(s / (n * n) / 17)) for s in sums)
    return [[pixel(x, y) for x in range(width // n)] for y in range(height // n)]


def to_svg(pixels):
    width, height, paths = len(pixels[0]), len(pixels), {}
    for y, row in enumerate(pixels):
        x = 0
        while x < width:
            end = x
            while end < width and row[end] == row[x]:
                end += 1
            paths.setdefault(row[x], []).append("M%d %dh%d" % (x, y, end - x))
            x = end
    body = "".join('<path stroke="#%s" d="%s"/>\n' % (c, "".join(runs)) for c, runs in sorted(paths.items()))
    return ('<svg xmlns="http://www.w3.org/2000/svg" width="%d" height="%d" viewBox="0 -.5 %d %d" shape-rendering="crispEdges">\n%s</svg>\n'
            % (4 * width, 4 * height, width, height, body))


if __name__ == "__main__":
    picture = read_png(sys.argv[1])
    open(sys.argv[2], "w").write(to_svg(shrink(*picture, int(sys.argv[3]) if len(sys.argv) > 3 else 1)))
