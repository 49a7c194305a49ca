"""Holds a solve of the hall against the path-traced reference: reference.py OUT/illuminance.csv

Path-traced: write 1 20 FOLDER, then
solve FOLDER/scene.toml --method path-tracing --paths 131072 --seed 9
"""
import csv
import pathlib
import sys


def lines(path):
    with open(path, newline="") as file:
        return [row for row in csv.DictReader(file) if row["status"] == "ok"]


reference = {row["point"]: row for row in lines(pathlib.Path(__file__).parent / "reference.csv")}
pairs = [(row, reference[row["point"]]) for row in lines(sys.argv[1])]
mean = sum(float(r["illuminance_lx"]) for _, r in pairs) / len(pairs)
inside, squares, ratios, bias = 0, [], [], 0.0
for row, r in pairs:
    exact, exact_error = float(r["illuminance_lx"]), float(r["error_lx"])
    difference, stated = float(row["illuminance_lx"]) - exact, float(row["error_lx"])
    inside += abs(difference) <= (stated**2 + exact_error**2) ** 0.5
    squares.append((difference / max(exact, 0.1 * mean)) ** 2)
    ratios.append(stated / max(abs(difference), 1e-9))
    bias += difference
n = len(pairs)
median = sorted(squares)[n // 2] ** 0.5
print(f"{n} points, mean {mean:.1f} lx, bias {100 * bias / n / mean:.2f} %, RMS {100 * (sum(squares) / n) ** 0.5:.2f} %,")
print(f"median {100 * median:.2f} %, largest {100 * max(squares) ** 0.5:.1f} %, {100 * inside / n:.1f} % inside the stated errors,")
print(f"stated over true, median: {sorted(ratios)[n // 2]:.1f}")
