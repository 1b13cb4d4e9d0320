"""Run a shipped scenario, read its arrays by name, and draw one picture of one's own."""

from __future__ import annotations

import sys
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt

from equipoise import run_scenario


def main(folder: str = "runs/example", *overrides: str) -> Path:
    """Run the tray into `folder` and plot squeeze force and torques; return the picture."""
    run = run_scenario("tray", out=folder, overrides=overrides, figures=False)
    for name, row in run.metrics.items():
        if "wanted" in row:
            print(f"{name:<22}{row['value']:>12.3g} {row['unit']:<4}{row['wanted']}")

    figure, (upper, lower) = plt.subplots(2, sharex=True, figsize=(8, 5), layout="constrained")
    squeeze = run.channels["lam/grasp"].labels.index("fz")
    upper.plot(run.t, run["lam/grasp"][:, squeeze], label="squeeze")
    upper.plot(run.t, run["lam_ref/grasp"], "--", label="wanted")
    upper.set_ylabel("N")
    upper.legend()
    busiest = abs(run["tau"]).max(axis=0).argsort()[-4:]
    for joint in busiest:
        lower.plot(run.t, run["tau"][:, joint], label=run.channels["tau"].labels[joint])
    lower.set(xlabel="t [s]", ylabel="N m")
    lower.legend(ncols=2)
    path = Path(folder) / "squeeze.png"
    figure.savefig(path)
    plt.close(figure)
    print(path)
    return path


if __name__ == "__main__":
    main(*sys.argv[1:])
