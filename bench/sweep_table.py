#!/usr/bin/env python3
"""Run time against error of every configuration on several scenes, from the JSON that accel-trace writes with --sweep (bench/sweep.sh).

x Embree  speed as a multiple of rtcIntersect1 in Embree's fast mode, medium quality: geometric mean over the scenes, primary and diffuse rays
wrong/M   wrong hits per million edge rays, mean over the scenes: misses, hits behind the true one, hits where there is none
t ulp     the largest error of t of a right hit, on any scene and kind
B/tri     bytes a triangle, the median of the scenes
prim diff nanoseconds a ray, primary and diffuse; * on the front of that scene and kind (errors are the higher of the rates of these and of
          edge rays)
wrong     wrong hits per million edge rays
"""

import json
import statistics
import sys
from collections import defaultdict
from pathlib import Path

KINDS = ("primary", "diffuse", "edge")


def configuration(row):
    """As accel-trace names it: the method, and the triangle test unless it is the default."""
    test = row.get("test", "watertight")
    return row["method"] + ("" if test == "watertight" else f" + {test}")


def read(paths):
    """{configuration: {scene: {kind: row}}}, and the context of the last file."""
    rows = defaultdict(lambda: defaultdict(dict))
    for path in paths:
        run = json.loads(Path(path).read_text())
        for row in run["benchmarks"]:
            if "ns_per_ray" in row:
                rows[configuration(row)][Path(path).stem][row["rays_kind"]] = row
    return rows, run["context"]


def short(number):
    """Three digits, never as a power."""
    return f"{number:.3g}" if 0.01 <= abs(number) < 1000 else f"{number:.0f}"


def summary(scenes):
    """x Embree, wrong per million, largest error of t, bytes a triangle."""
    rows = [row for kinds in scenes.values() for row in kinds.values()]
    timed = [kinds[kind]["ratio_to_embree"] for kinds in scenes.values() for kind in KINDS[:2] if kind in kinds]
    wrong = [kinds["edge"]["edge_error"]["per_million"] for kinds in scenes.values() if "edge" in kinds]
    return (statistics.geometric_mean(timed), statistics.mean(wrong), max((row["t_ulp"]["max"] for row in rows if "t_ulp" in row), default=0),
            statistics.median(row["bytes_per_triangle"] for row in rows))


def cells(kinds):
    """Of one configuration on one scene."""
    for kind in KINDS[:2]:
        yield short(kinds[kind]["ns_per_ray"]) + ("*" if kinds[kind]["pareto"] else " ") if kind in kinds else "- "
    yield f"{kinds['edge']['edge_error']['per_million']:.0f}" if "edge" in kinds else "-"


def table(rows):
    names = sorted({scene for scenes in rows.values() for scene in scenes})
    width = max(map(len, rows)) + 1
    lines = [f"{'':{width}}{'x Embree':>9}{'wrong/M':>9}{'t ulp':>7}{'B/tri':>7}" + "".join(f"{name[:19]:>22}" for name in names),
             f"{'configuration':{width}}{'speed':>9}{'edge':>9}{'max':>7}{'median':>7}" + f"{'prim ':>8}{'diff ':>7}{'wrong':>7}" * len(names)]
    ranked = sorted(((summary(scenes), name) for name, scenes in rows.items()), reverse=True)
    for (speed, wrong, ulp, size), name in ranked:
        line = f"{name:{width}}{speed:>9.2f}{wrong:>9.1f}{short(ulp):>7}{size:>7.1f}"
        for scene in names:
            primary, diffuse, edge = cells(rows[name][scene])
            line += f"{primary:>8}{diffuse:>7}{edge:>7}"
        lines.append(line)
    return lines


def main():
    if len(sys.argv) < 2 or sys.argv[1].startswith("-"):
        sys.exit(__doc__ + "\nusage: sweep_table.py FILE.json ...")
    rows, context = read(sys.argv[1:])
    print(__doc__.split("\n\n", 1)[1])
    print("\n".join(table(rows)))
    print(f"\n{context['date'][:10]}, {context['threads']} threads, {context['width']} x {context['height']} rays of each kind, "
          f"medians of {context['repeat']} runs in turns, {context['versions']['embree']}")


if __name__ == "__main__":
    main()
