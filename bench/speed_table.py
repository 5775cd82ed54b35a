#!/usr/bin/env python3
"""Speed against Embree as Markdown, from the JSON that accel-trace writes with --embree all (bench/speed.sh).

Each cell is a multiple of rtcIntersect1 or rtcOccluded1 (medium quality, fast mode), of the same run; in brackets, of Embree's fastest mode for
the rays, whatever it is: packets of 8 or 16 rays or coherent streams, medium or high quality. Below 1, Embree is faster.
"""

import json
import statistics
import sys
from pathlib import Path


def read(path):
    """{rays' kind: (x rtcIntersect1, x best mode, spread)} of the first method in a file, and the file's context."""
    run = json.loads(Path(path).read_text())
    ours = [row for row in run["benchmarks"] if "ratio_to_embree" in row and not row["method"].startswith("Embree")]
    method = ours[0]["method"]
    kinds = {}
    for row in ours:
        if row["method"] != method:
            continue
        spread = (row["mrays_max"] - row["mrays_min"]) / row["mrays_per_second"]
        kinds[row["rays_kind"]] = (row["ratio_to_embree"], row["ratio_to_best_embree"], spread)
    return kinds, run["context"], method


def cell(values):
    return f"{values[0]:.2f} ({values[1]:.2f})"


def table(scenes):
    kinds = list(dict.fromkeys(kind for scene in scenes.values() for kind in scene))
    lines = ["| scene | " + " | ".join(kinds) + " |", "| --- |" + " --- |" * len(kinds)]
    medians = [cell([statistics.median(s[kind][i] for s in scenes.values() if kind in s) for i in (0, 1)]) for kind in kinds]
    lines.append("| **median** | " + " | ".join(f"**{m}**" for m in medians) + " |")
    for name, scene in scenes.items():
        lines.append(f"| {name} | " + " | ".join(cell(scene[kind]) if kind in scene else "-" for kind in kinds) + " |")
    return lines


def cpu_name():
    """Of the machine that this runs on."""
    names = [line.split(":")[1].strip() for line in Path("/proc/cpuinfo").read_text().splitlines() if line.startswith("model name")]
    return names[0] if names else "unknown CPU"


def main():
    if len(sys.argv) < 2 or sys.argv[1].startswith("-"):
        sys.exit(__doc__ + "\nusage: speed_table.py FILE.json ...")
    scenes = {}
    for path in sys.argv[1:]:
        scenes[Path(path).stem], context, method = read(path)
    widest = max(spread for scene in scenes.values() for _, _, spread in scene.values())
    print(f"`{method}` as a multiple of rtcIntersect1 or rtcOccluded1 (in brackets: of Embree's fastest mode for the rays)\n")
    print("\n".join(table(scenes)))
    print(f"\n{context['date'][:10]}, {cpu_name()}, {context['threads']} thread(s), {context['versions']['embree']}; "
          f"(max - min) / median of our runs: at most {widest:.0%}.")


if __name__ == "__main__":
    main()
