"""Where the accelerations of a reference change: how much in kinks, and which rows make them.

`python benchmarks/reference_roughness.py tray [--robot talos] [--set KEY=VALUE ...]`: the reference
alone, without a law or an engine. Prints the total variation of dv_ref/dt over all joints, as it
is, as it would be without eases, and without any inequality of the file; then the share in ticks
that stand out (more than `STANDS_OUT` times the median of their surroundings), each with the rows
that became active or let go there and the joints that felt it.
`--picture FILE` draws the accelerations of the joints with and without eases.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np

from equipoise.analysis.metrics.smoothness import acceleration_steps
from equipoise.hqp import Hierarchy, Solution
from equipoise.scenarios import read_scenario
from equipoise.simulation.simulation import Simulation
from equipoise.spatial import Array

STANDS_OUT = 5.0
AROUND = 25  # ticks to either side that a tick is compared with
LEAST = 0.05  # [rad/s^2] what is less is no kink
NEAR = 3  # ticks within which an active row and a kink belong together
INEQUALITIES = ("com_polygon", "joint_limits", "avoidance", "keep_in", "keep_out")


class Reference:
    """The reference of a scenario: velocities `v` (N, na), and the active bounds of each tick."""

    def __init__(self, name: str, robot: str | None, overrides: list[str]) -> None:
        simulation = Simulation(read_scenario(name, overrides, robot=robot))
        motion, self.dt = simulation.controller.motion, simulation.dt
        self.joints = simulation.robot.joint_names
        v, self.active = [], []
        for k in range(simulation.steps):
            step = motion.step(k * self.dt)
            v.append(step.v_ref[simulation.robot.nv_base :])
            self.active.append(active_rows(step.hierarchy, step.solution))
        self.v = np.array(v)
        self.steps = acceleration_steps(self.v, self.dt)

    def kinks(self) -> Array:
        """Return the ticks (k,) whose acceleration changes more than around them."""
        per_tick = self.steps.sum(axis=1)
        found = []
        for k in range(len(per_tick)):
            near = per_tick[max(k - AROUND, 0) : k + AROUND + 1]
            if per_tick[k] > max(STANDS_OUT * float(np.median(near)), LEAST):
                found.append(k)
        return np.array(found, dtype=int)

    def changes(self, k: int) -> tuple[list[str], list[str]]:
        """Return which rows became active around tick k, and which let go."""
        before, after = self.active[max(k - NEAR, 0)], self.active[min(k + NEAR, len(self.v) - 1)]
        return sorted(after - before), sorted(before - after)


def active_rows(hierarchy: Hierarchy, solution: Solution) -> frozenset[str]:
    """Return the names of the inequalities that are active."""
    names = [f"{block.name}/{label}" for block in hierarchy.blocks for label in block.labels]
    bounds = np.flatnonzero(solution.active & (hierarchy.lower < hierarchy.upper))
    return frozenset(names[row] for row in bounds)


def without(name: str, robot: str | None, inequalities: bool) -> list[str]:
    """Return the overrides that switch off the eases of a file, or its inequalities."""
    tasks = read_scenario(name, robot=robot).tasks
    if inequalities:
        wanted = [task for task, spec in tasks.items() if spec.kind in INEQUALITIES]
        return [f"tasks.{task}.enabled=false" for task in wanted]
    return [f"tasks.{task}.ease=null" for task, spec in tasks.items() if spec.ease is not None]


def tell(title: str, reference: Reference) -> None:
    """Print the variation of a reference, and its kinks."""
    kinks, total = reference.kinks(), float(reference.steps.sum())
    inside = float(reference.steps[kinks].sum())
    print(
        f"{title}: {total:.1f} rad/s^2, {inside:.1f} of it in {len(kinks)} ticks that stand out; "
        f"largest jerk {reference.steps.max() / reference.dt:.0f} rad/s^3"
    )
    last = -AROUND
    for k in kinks:
        if k - last <= NEAR:
            continue
        last = k
        around = reference.steps[k : k + NEAR].sum(axis=0)
        most = [f"{reference.joints[j]} {around[j]:.2f}" for j in np.argsort(around)[::-1][:3]]
        on, off = reference.changes(int(k))
        rows = [*(f"+ {row}" for row in on), *(f"- {row}" for row in off)]
        print(
            f"  {(k + 1) * reference.dt:.3f} s: {around.sum():.2f} ({', '.join(most)}): "
            f"{'; '.join(rows) or 'no change of the active rows'}"
        )


def draw(path: Path, references: dict[str, Reference]) -> None:
    """Draw the accelerations of all joints over time, one axis a reference."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot as plt

    fig, axes = plt.subplots(
        len(references), 1, sharex=True, sharey=True, figsize=(9.0, 5.2), layout="constrained"
    )
    for ax, (title, one) in zip(np.atleast_1d(axes), references.items(), strict=True):
        a = np.diff(one.v, axis=0) / one.dt
        moves = np.abs(a).max(axis=0)
        colours = plt.get_cmap("viridis")(np.linspace(0.0, 0.9, a.shape[1]))
        for place, j in enumerate(np.argsort(moves)):
            ax.plot(np.arange(len(a)) * one.dt, a[:, j], lw=0.9, color=colours[place])
        ax.set_title(f"{title}: {one.steps.sum():.0f} rad/s²", loc="left", fontsize=10)
        ax.set_ylabel("rad/s²")
        ax.spines[["top", "right"]].set_visible(False)
        ax.margins(x=0.0)
    np.atleast_1d(axes)[-1].set_xlabel("time [s]")
    fig.savefig(path, dpi=110)


def main() -> None:
    """Tell of the scenario that is named."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("scenario")
    parser.add_argument("--robot")
    parser.add_argument("--set", action="append", default=[], dest="overrides")
    parser.add_argument(
        "--before", action="append", default=[], help="what else differs in what is told first"
    )
    parser.add_argument("--picture", type=Path)
    given = parser.parse_args()
    name, robot, sets = given.scenario, given.robot, given.overrides
    told = {
        "before" if given.before else "without eases": [
            *sets,
            *without(name, robot, False),
            *given.before,
        ],
        "as it is": sets,
    }
    references = {title: Reference(name, robot, more) for title, more in told.items()}
    bare = Reference(name, robot, [*sets, *without(name, robot, True)])
    for title, reference in references.items():
        tell(title, reference)
    tell("without any inequality", bare)
    if given.picture:
        draw(given.picture, references)


if __name__ == "__main__":
    main()
