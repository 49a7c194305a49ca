#!/usr/bin/env python3
"""Measure Radiance's rtrace on scene.toml of this folder and write a peer file for `clerestory chart --peer`.

    pip install pyradiance
    python3 radiance.py REFERENCE.csv PEER.csv

REFERENCE.csv is the reference.csv that `clerestory chart scene.toml` writes: the same points, the same truth. Radiance
gets the same polygons, reflectances and luminance (179 lm/W at its border). Every setting is run three times, one that
takes more than ten seconds once; processor time (of oconv and rtrace together) and errors are medians.
"""

import csv
import math
import os
import resource
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import pyradiance

HERE = Path(__file__).resolve().parent
RADIANCE = Path(pyradiance.__file__).parent
OBJ = HERE / "../../validation/cornell/cornell.obj"
REFLECTANCE = {"white": 0.75, "red": 0.2, "green": 0.25}
LUMINANCE_CD_M2 = 10000.0
EFFICACY_LM_W = 179.0
REPEATS = 3

# From coarse to fine: the manual's advice for -ab, -ad, -as, -aa, -ar going together, and the last without a cache.
LADDER = [
    "-ab 2 -ad 128 -as 32 -aa .3 -ar 32",
    "-ab 3 -ad 256 -as 64 -aa .25 -ar 64",
    "-ab 4 -ad 512 -as 128 -aa .2 -ar 128",
    "-ab 6 -ad 64 -aa 0 -lw 2e-3",
    "-ab 8 -ad 256 -aa 0 -lw 5e-4",
]
ALWAYS = "-I -h -dj 0.7 -ds 0.02 -dt 0 -dc 1 -dr 0 -st 1"


def scene_text():
    """The OBJ as Radiance polygons, metres; sides that face the right-hand rule's way emit."""
    radiance = LUMINANCE_CD_M2 / EFFICACY_LM_W
    lines = [f"void light light 0 0 3 {radiance} {radiance} {radiance}"]
    for name, rho in REFLECTANCE.items():
        lines.append(f"void plastic {name} 0 0 5 {rho} {rho} {rho} 0 0")
    vertices, material = [], None
    for row in OBJ.read_text().splitlines():
        words = row.split()
        if not words or words[0] in ("#", "o"):
            continue
        if words[0] == "v":
            vertices.append([float(x) / 1000.0 for x in words[1:4]])
        elif words[0] == "usemtl":
            material = words[1]
        elif words[0] == "f":
            corners = [vertices[int(k) - 1] for k in words[1:]]
            numbers = " ".join(f"{x:.9g}" for corner in corners for x in corner)
            lines.append(f"{material} polygon face{len(lines)} 0 0 {3 * len(corners)} {numbers}")
    return "\n".join(lines) + "\n"


def run(folder, setting, points):
    """Illuminances, processor time and wall time of one run."""
    environment = dict(os.environ, RAYPATH=f".:{RADIANCE / 'lib'}")
    before, start = resource.getrusage(resource.RUSAGE_CHILDREN), time.monotonic()
    tree = subprocess.run([RADIANCE / "bin/oconv", folder / "box.rad"], check=True, capture_output=True, env=environment).stdout
    (folder / "box.oct").write_bytes(tree)
    command = [RADIANCE / "bin/rtrace", *ALWAYS.split(), *setting.split(), folder / "box.oct"]
    out = subprocess.run(command, input=points, check=True, capture_output=True, text=True, env=environment).stdout
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    cpu = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    wall = time.monotonic() - start
    weights = (0.265, 0.670, 0.065)
    lux = [EFFICACY_LM_W * sum(w * float(x) for w, x in zip(weights, line.split())) for line in out.splitlines() if line.strip()]
    return lux, cpu, wall, after.ru_maxrss * 1024 / 1e6


def errors(lux, truth, standard_errors):
    """The columns of chart.csv that tell errors, by the same formulas."""
    mean = statistics.fmean(truth)
    uncertainty = math.sqrt(statistics.fmean(s * s for s in standard_errors)) / mean
    raw = math.sqrt(statistics.fmean((a - b) ** 2 for a, b in zip(lux, truth))) / mean
    resolved = raw > 2 * uncertainty
    own = sorted(abs(a - b) / max(b, 0.01 * mean) for a, b in zip(lux, truth))
    return {
        "rms_rel": math.sqrt(raw * raw - uncertainty * uncertainty) if resolved else raw,
        "mbe_rel": statistics.fmean(a - b for a, b in zip(lux, truth)) / mean,
        "p95_rel": own[round(0.95 * (len(own) - 1))],
        "max_rel": own[-1],
        "resolved": str(resolved).lower(),
    }


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    with open(sys.argv[1]) as file:
        reference = list(csv.DictReader(file))
    truth = [float(r["illuminance_lx"]) for r in reference]
    standard_errors = [float(r["standard_error_lx"]) for r in reference]
    # A point on a surface would be hidden by it: 0.01 mm before it, against 550 mm of room.
    axes = ("x", "y", "z")
    lines = []
    for r in reference:
        normal = [float(r[f"n{a}"]) for a in axes]
        place = [float(r[f"{a}_m"]) + 1e-5 * n for a, n in zip(axes, normal)]
        lines.append(" ".join(f"{x:.9g}" for x in place + normal))
    points = "\n".join(lines) + "\n"
    columns = "method,setting,cpu_s,wall_s,peak_mem_mb,rms_rel,mbe_rel,p95_rel,max_rel,resolved".split(",")
    with tempfile.TemporaryDirectory() as name, open(sys.argv[2], "w", newline="") as file:
        folder = Path(name)
        (folder / "box.rad").write_text(scene_text())
        writer = csv.DictWriter(file, columns)
        writer.writeheader()
        for setting in LADDER:
            runs = []
            while len(runs) < REPEATS and (not runs or runs[0][1] < 10.0):
                runs.append(run(folder, setting, points))
            found = [errors(r[0], truth, standard_errors) for r in runs]
            row = {"method": "Radiance rtrace", "setting": setting}
            for k, column in ((1, "cpu_s"), (2, "wall_s"), (3, "peak_mem_mb")):
                row[column] = statistics.median(r[k] for r in runs)
            for column in ("rms_rel", "mbe_rel", "p95_rel", "max_rel"):
                row[column] = statistics.median(f[column] for f in found)
            row["resolved"] = found[0]["resolved"]
            writer.writerow(row)
            file.flush()
            print(f"{setting}: {row['cpu_s']:.2f} s, RMS {100 * row['rms_rel']:.2f} %, bias {100 * row['mbe_rel']:+.2f} %")


if __name__ == "__main__":
    main()
