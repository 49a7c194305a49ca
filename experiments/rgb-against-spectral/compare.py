"""Three bands of red, green and blue, and the bands that the program chooses, against all bands of the same scene.

Runs `clerestory solve` on copies of the scenes whose [bands] are changed, writes points.csv (every point), results.csv (what
differs) and chart.svg. Standard library alone.

    cargo build --release
    python3 experiments/rgb-against-spectral/compare.py target/release/clerestory
"""

import csv
import json
import math
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

HERE = pathlib.Path(__file__).parent
ROOT = HERE.parent.parent
SCENES = {"Cornell box": "validation/cornell/points.toml", "louvre": "experiments/ferren/louvre.toml"}
MODES = {"rgb": '"rgb"', "auto": '"auto"'}
TOLERANCE = "1%"


def u_v(x, y):
    """u'v' of CIE 1976."""
    d = -2.0 * x + 12.0 * y + 3.0
    return 4.0 * x / d, 9.0 * y / d


def solve(program, scene, mode, seed=1):
    """The points of a scene in some bands: grid and point → illuminance, its error, u'v'; the number of bands."""
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder) / "scene"
        shutil.copytree(ROOT / pathlib.Path(scene).parent, folder)
        file = folder / pathlib.Path(scene).name
        text = file.read_text().split("[[views]]")[0]
        if mode:
            text = re.sub(r"^mode = .*$", f"mode = {mode}", text, count=1, flags=re.M)
        file.write_text(text)
        command = [program, "solve", file, "-o", folder / "out", "--tolerance", TOLERANCE, "--seed", str(seed), "-q"]
        code = subprocess.run([str(c) for c in command], stdout=subprocess.DEVNULL, check=False).returncode
        if code not in (0, 3):
            sys.exit(f"{command} answers {code}")
        run = json.loads((folder / "out" / "run.json").read_text())
        points = {}
        with open(folder / "out" / "illuminance.csv", newline="") as table:
            for row in csv.DictReader(table):
                if row["status"] == "ok":
                    place = (row["grid"], int(row["point"]))
                    uv = u_v(float(row["cie_x"]), float(row["cie_y"]))
                    points[place] = (float(row["illuminance_lx"]), float(row["error_lx"]), uv)
        bands = next(s["value"] for s in run["settings"] if s["name"] == "bands")
        return points, bands


def quantile(values, q):
    values = sorted(values)
    return values[min(len(values) - 1, math.ceil(q * len(values)) - 1)]


def differences(a, b):
    """Of b against a: relative illuminance and distance in u'v', point by point."""
    return [(p, b[p][0] / a[p][0] - 1.0, math.dist(a[p][2], b[p][2])) for p in sorted(a)]


def chart(panels):
    """Every point: illuminance over u'v'."""
    wide, tall, room = 380, 300, 60
    colours = {"rgb": "#c0392b", "auto": "#2a6fb0", "another seed": "#888888"}
    most_e, most_c = 12.0, 0.03
    svg = [
        f"<svg xmlns='http://www.w3.org/2000/svg' width='{len(panels) * (wide + room) + room}' height='{tall + 110}' "
        "font-family='sans-serif' font-size='13'><rect width='100%' height='100%' fill='white'/>"
    ]
    for k, (scene, modes) in enumerate(panels.items()):
        left, top = room + k * (wide + room), 40
        x = lambda c: left + min(c, most_c) / most_c * wide
        y = lambda e: top + (most_e - max(-most_e, min(most_e, e))) / (2.0 * most_e) * tall
        svg.append(f"<text x='{left + wide / 2}' y='24' text-anchor='middle'>{scene}: against all bands</text>")
        svg.append(f"<rect x='{left}' y='{top}' width='{wide}' height='{tall}' fill='none' stroke='black'/>")
        for e in range(-12, 13, 4):
            svg.append(f"<line x1='{left}' x2='{left + wide}' y1='{y(e):.1f}' y2='{y(e):.1f}' stroke='#ddd'/>")
            svg.append(f"<text x='{left - 6}' y='{y(e) + 4:.1f}' text-anchor='end'>{e}</text>")
        for c in (0.0, 0.01, 0.02, 0.03):
            svg.append(f"<text x='{x(c):.1f}' y='{top + tall + 18}' text-anchor='middle'>{c:g}</text>")
        for mode, list_ in modes.items():
            for _, e, c in list_:
                svg.append(
                    f"<circle cx='{x(c):.1f}' cy='{y(100 * e):.1f}' r='2.2' fill='{colours[mode]}' fill-opacity='0.55'/>"
                )
        svg.append(f"<text x='{left + wide / 2}' y='{top + tall + 38}' text-anchor='middle'>distance in u'v'</text>")
        svg.append(
            f"<text transform='translate({left - 34} {top + tall / 2}) rotate(-90)' text-anchor='middle'>"
            "illuminance, %</text>"
        )
    for k, (mode, colour) in enumerate(colours.items()):
        name = {"rgb": "red, green, blue", "auto": "bands of the program's choice"}.get(mode, "all bands, another seed")
        svg.append(f"<text x='{room + 250 * k}' y='{tall + 98}' fill='{colour}'>● {name}</text>")
    return "\n".join(svg) + "\n</svg>\n"


def main():
    program = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else "target/release/clerestory").resolve()
    panels, rows, results = {}, [], []
    for scene, path in SCENES.items():
        truth, bands = solve(program, path, None)
        panels[scene] = {}
        # What the noise alone does: the same bands with another seed.
        runs = {mode: solve(program, path, key) for mode, key in MODES.items()}
        runs["another seed"] = solve(program, path, None, seed=2)
        for mode, (points, count) in runs.items():
            list_ = differences(truth, points)
            panels[scene][mode] = list_
            off, uv = [abs(d[1]) for d in list_], [d[2] for d in list_]
            results.append(
                [scene, mode, count, bands, len(list_)]
                + [f"{100 * v:.2f}" for v in (quantile(off, 0.5), quantile(off, 0.95), max(off))]
                + [f"{v:.4f}" for v in (quantile(uv, 0.5), quantile(uv, 0.95), max(uv))]
            )
            print(*results[-1])
            rows += [[scene, mode, *p, f"{100 * e:.3f}", f"{c:.5f}"] for p, e, c in list_]
    heads = "scene,mode,bands,bands_of_the_whole,points,median_percent,p95_percent,most_percent,median_uv,p95_uv,most_uv"
    for name, head, lines in [
        ("results.csv", heads.split(","), results),
        ("points.csv", ["scene", "mode", "grid", "point", "illuminance_percent", "u_v"], rows),
    ]:
        with open(HERE / name, "w", newline="") as file:
            writer = csv.writer(file, lineterminator="\n")
            writer.writerow(head)
            writer.writerows(lines)
    (HERE / "chart.svg").write_text(chart(panels))


if __name__ == "__main__":
    main()
