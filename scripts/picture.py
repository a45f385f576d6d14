#!/usr/bin/env python3
"""Draws the picture of the README: a frame with its points, and the trajectory beside the truth.

  scripts/picture.py RECORDING RESULT OUT.png     after `pled-vins replay RECORDING --out RESULT`

Needs Debian's python3-numpy and python3-matplotlib.
"""
import csv
import sys
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np


def align(estimate, truth):
    """Rotation and shift that lay `estimate` (n, 3) on `truth` best; no scale (Umeyama, 1991)."""
    e0, t0 = estimate.mean(0), truth.mean(0)
    u, _, v = np.linalg.svd((truth - t0).T @ (estimate - e0))
    flip = np.diag([1, 1, np.sign(np.linalg.det(u @ v))])
    rotation = u @ flip @ v
    return (estimate - e0) @ rotation.T + t0


def features_at(result, stamp):
    with open(result / "features.csv", newline="") as file:
        return [row for row in csv.DictReader(file) if row["t"] == stamp]


def main():
    if len(sys.argv) != 4:
        sys.exit(__doc__)
    recording, result, out = map(Path, sys.argv[1:])
    poses = np.loadtxt(result / "trajectory.tum")
    truth = np.loadtxt(recording / "groundtruth.txt")
    at_poses = np.stack([np.interp(poses[:, 0], truth[:, 0], truth[:, k]) for k in (1, 2, 3)], 1)
    estimate = align(poses[:, 1:4], at_poses)
    ate_m = np.sqrt(((estimate - at_poses) ** 2).sum(1).mean())

    frames = [line.split() for line in open(recording / "images.txt") if not line.startswith("#")]
    stamp_s, name = min(frames, key=lambda f: abs(float(f[0]) - poses[len(poses) // 2, 0]))
    rows = features_at(result, f"{float(stamp_s):.9f}")

    figure, (left, right) = plt.subplots(1, 2, figsize=(10, 4), width_ratios=(1.2, 1))
    left.imshow(plt.imread(recording / name), cmap="gray")
    for used, colour, label in ((True, "#1b9e77", "used"), (False, "#d95f02", "not used")):
        chosen = [r for r in rows if (r["used"] == "1") == used]
        left.scatter([float(r["u0_px"]) for r in chosen], [float(r["v0_px"]) for r in chosen],
                     s=14, facecolors="none", edgecolors=colour, label=f"{label} ({len(chosen)})")
    left.legend(loc="lower right", fontsize=8)
    left.set_title(f"points at {float(stamp_s):.2f} s")
    left.set_axis_off()

    right.plot(truth[:, 1], truth[:, 2], color="#999999", lw=3, label="truth")
    right.plot(estimate[:, 0], estimate[:, 1], color="#1b9e77", lw=1.2, label="estimate")
    right.plot(*estimate[0, :2], "o", color="#1b9e77", ms=5, label="start")
    right.set_aspect("equal", adjustable="datalim")
    right.set_xlabel("x, m")
    right.set_ylabel("y, m")
    right.legend(fontsize=8)
    right.set_title(f"from above: ATE {1e3 * ate_m:.0f} mm")
    figure.tight_layout()
    figure.savefig(out, dpi=90)


if __name__ == "__main__":
    main()
