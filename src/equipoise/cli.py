"""The commands, declared in one place (those of studies in theirs): that is why it is long.

Each imports what it needs when it is called, so that `--help` answers at once.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Callable
from dataclasses import replace
from functools import wraps
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import click

from equipoise import __version__
from equipoise.errors import EquipoiseError, InputError
from equipoise.studies import commands as of_studies

if TYPE_CHECKING:
    from equipoise.api import Output
    from equipoise.remote.options import WireOptions
    from equipoise.runlog import Run

PASSED, NOT_PASSED, WRONG_INPUT, INTERRUPTED = 0, 1, 2, 130


@click.group(context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(__version__, prog_name="equipoise")
def cli() -> None:
    """Whole-body force-motion control of humanoids without a dynamic model.

    Exit codes: 0 done (a run: and met its acceptance), 1 ran but did not meet it, 2 wrong input
    or a place that cannot be read or written.
    """


for _command in (of_studies.study, of_studies.compare, of_studies.tune):
    cli.add_command(_command)


def page_options(command: Callable[..., None]) -> Callable[..., None]:
    """Add where a page is served; the command gets it as `address`: host and port."""

    @click.option(
        "--port", type=click.IntRange(0, 65535), help="Port of the page [first free: 8080]."
    )
    @click.option("--host", default="127.0.0.1", help="Address to listen on [this machine only].")
    @wraps(command)
    def with_address(*, host: str, port: int | None, **given: Any) -> None:
        command(address=(host, port), **given)

    return with_address


def value_options(command: Callable[..., None]) -> Callable[..., None]:
    """Add what changes values of a scenario; the command gets it as `overrides`, in order."""

    @click.option(
        "--set", "single", multiple=True, metavar="PATH=VALUE", help="Change one value; repeatable."
    )
    @click.option(
        "--gains", type=click.Path(path_type=Path), help="Change those of a file of gains."
    )
    @click.option("--physics", "engine", metavar="ENGINE", help="Engine: rigid or mujoco.")
    @click.option(
        "--controller", "kind", metavar="KIND", help="Controller: passivity or a rival, say idqp."
    )
    @wraps(command)
    def with_overrides(
        *,
        single: tuple[str, ...],
        gains: Path | None,
        engine: str | None,
        kind: str | None,
        **given: Any,
    ) -> None:
        overrides = single
        if gains is not None:
            from equipoise.scenarios.gains_file import gains_overrides

            overrides = (*gains_overrides(gains), *overrides)
        if engine is not None:
            overrides = (*overrides, f"physics.engine={engine}")
        if kind is not None:
            overrides = (*overrides, f"control.kind={kind}")
        command(overrides=overrides, **given)

    return with_overrides


@cli.command()
@click.argument("scenario")
@click.option("--out", type=click.Path(path_type=Path), help="Folder of the run (must be new).")
@value_options
@click.option("--robot", metavar="ROBOT", help="Refit it to this robot (a name or a file).")
@click.option("--no-figures", is_flag=True, help="Write no figures.")
@click.option("--view", "watched", is_flag=True, help="Show it in the browser while it runs.")
@page_options
def run(
    scenario: str,
    out: Path | None,
    overrides: tuple[str, ...],
    robot: str | None,
    no_figures: bool,
    watched: bool,
    address: tuple[str, int | None],
) -> None:
    """Run SCENARIO (a name or a YAML file), log it, and say what was achieved.

    --set changes one value and can be given several times. PATH is the way to it, names and numbers
    of list items (from 0) joined by dots; VALUE is YAML. Quote what has spaces or brackets:

    \b
      equipoise run tray --set disturbances.mass_scale=1.3 --set duration=3
      equipoise run tray --set world.objects.tray.waypoints.4.xyz=[0.52,0,0.86]
      equipoise run tray --set 'disturbances.payloads=[{mass: 2.0, object: tray}]'
      equipoise run tray --set 'title=A tray, heavier'
    """
    from equipoise.api import run_scenario

    def carry_out(output: Output) -> Run:
        return run_scenario(
            scenario,
            out=output.out,
            overrides=overrides,
            robot=robot,
            figures=output.figures,
            report=output.report,
            measured=output.measured,
            steer=output.steer,
        )

    _carry_out(carry_out, out, no_figures=no_figures, watched=watched, address=address)


def _carry_out(
    carry_out: Callable[[Output], Run],
    out: Path | None,
    *,
    no_figures: bool,
    watched: bool,
    address: tuple[str, int | None],
) -> None:
    """Run with a bar, a table, perhaps a page; exit with what came out."""
    from equipoise.api import Output
    from equipoise.console import Progress, print_figures, print_summary

    watch = None
    if watched:
        from equipoise.viewer.commands import Watch

        watch = Watch(*address, click.echo)
    with Progress() as progress:

        def show(measured: Run) -> None:
            progress.rest()
            print_summary(measured.summary or {}, measured.folder)

        steer = watch.steer if watch is not None else None
        finished = carry_out(Output(out, not no_figures, progress, show, steer))
    summary = finished.summary or {}
    print_figures(finished.folder)
    if watch is not None:
        watch.finish(finished.folder)
    if summary.get("ended") == "interrupted":
        sys.exit(INTERRUPTED)
    sys.exit(PASSED if summary.get("passed") else NOT_PASSED)


def wire_options(command: Callable[..., None]) -> Callable[..., None]:
    """Add how robot and controller are joined; the command gets it as `wire`, to be called."""

    @click.option(
        "--wire", "protocol", default="udp", show_default=True, help="udp, unitree or session:FILE."
    )
    @click.option("--wire-host", default="127.0.0.1", help="Robot's address or interface.")
    @click.option("--wire-port", type=click.IntRange(0, 65535), help="Port [47100], or DDS domain.")
    @click.option(
        "--lockstep/--realtime", default=True, help="The robot's time waits, or runs [waits]."
    )
    @wraps(command)
    def with_wire(
        *,
        protocol: str,
        wire_host: str,
        wire_port: int | None,
        lockstep: bool,
        record: Path | None = None,
        **given: Any,
    ) -> None:
        from equipoise.remote.options import WireOptions

        command(wire=WireOptions(protocol, wire_host, wire_port, lockstep, record), **given)

    return with_wire


@cli.command()
@click.argument("scenario")
@value_options
@click.option("--robot", metavar="ROBOT", help="Refit it to this robot (a name or a file).")
@click.option("--truth", type=click.Path(path_type=Path), help="Write the true states (npz).")
@click.option("--away", type=float, default=0.0, help="Begin with its arms off by this [rad].")
@wire_options
def plant(
    scenario: str,
    overrides: tuple[str, ...],
    robot: str | None,
    truth: Path | None,
    away: float,
    wire: WireOptions,
) -> None:
    """Be the robot of SCENARIO, simulated, for a controller in another process.

    Its sensors, delays and faults are those of the scenario. It stands until it is driven; left
    alone it holds its posture by its own servos for a moment, and ends.
    Example: equipoise plant press --robot g1 --realtime
    """
    from equipoise.remote.serve import serve_plant
    from equipoise.scenarios import read_scenario

    spec = read_scenario(scenario, overrides, robot=robot)
    far_end = serve_plant(spec, wire, click.echo, truth, away)
    if far_end.interrupted:
        sys.exit(INTERRUPTED)


@cli.command()
@click.argument("scenario")
@click.option("--arm", is_flag=True, help="Let the robot move; without it, it is only looked at.")
@click.option("--out", type=click.Path(path_type=Path), help="Folder of the run (must be new).")
@value_options
@click.option("--robot", metavar="ROBOT", help="Refit it to this robot (a name or a file).")
@click.option("--no-figures", is_flag=True, help="Write no figures.")
@click.option("--view", "watched", is_flag=True, help="Show it in the browser while it runs.")
@click.option("--record", type=click.Path(path_type=Path), help="Write the session to a new file.")
@page_options
@wire_options
def control(
    scenario: str,
    arm: bool,
    overrides: tuple[str, ...],
    robot: str | None,
    wire: WireOptions,
    **output: Any,
) -> None:
    """Drive the robot of SCENARIO in another process (equipoise plant), and log it as `run` does.

    Example: equipoise control press --robot g1 --realtime --arm
    """
    from equipoise.remote.control import control_robot
    from equipoise.scenarios import read_scenario

    spec = read_scenario(scenario, overrides, robot=robot)
    if not arm:
        control_robot(spec, wire, click.echo).close()
        click.echo("Nothing was commanded: nothing moves without --arm")
        return

    def carry_out(given: Output) -> Run:
        from equipoise.api import run_made

        armed = replace(wire, armed=True)
        return run_made(spec, lambda s: control_robot(s, armed, click.echo), given)

    _carry_out(carry_out, **output)


@cli.command()
@click.argument("run_folder", metavar="RUN", type=click.Path(path_type=Path))
def plot(run_folder: Path) -> None:
    """Draw the figures of RUN again, from its log."""
    from equipoise.analysis.figures.make import make_figures
    from equipoise.optional import require_package

    require_package("matplotlib", "plot", "a figure")
    from equipoise.runlog import load_run

    loaded = load_run(run_folder)
    _tell_note(loaded.note)
    for path in make_figures(loaded, loaded.folder / "figures"):
        click.echo(path)


@cli.command()
@click.argument("run_folders", metavar="[RUN]...", nargs=-1, type=click.Path(path_type=Path))
@click.option("--to", type=click.Path(path_type=Path), default="figures", show_default=True)
def figures(run_folders: tuple[Path, ...], to: Path) -> None:
    """Make a page like the paper's Figures 2 and 3 of each RUN, as PNG and PDF.

    Without RUN, the scenarios tray and telephone are run first.
    """
    from equipoise.analysis.figures.paper_page import write_paper_page
    from equipoise.api import run_scenario
    from equipoise.console import Progress
    from equipoise.runlog import load_run

    runs = [load_run(folder) for folder in run_folders]
    if not runs:
        with Progress() as progress:
            for name in ("tray", "telephone"):
                runs.append(run_scenario(name, figures=False, report=progress))
    for loaded in runs:
        _tell_note(loaded.note)
        for path in write_paper_page(loaded, to):
            click.echo(path)


@cli.command()
@click.argument("run_folder", metavar="RUN", type=click.Path(path_type=Path))
@click.option(
    "--format",
    "kind",
    type=click.Choice(["npz", "csv", "parquet", "rrd", "mcap"]),
    default="npz",
    show_default=True,
)
@click.option("--to", type=click.Path(path_type=Path), help="File to write [RUN/run.FORMAT].")
def export(run_folder: Path, kind: str, to: Path | None) -> None:
    """Write what RUN logged for other programs.

    npz, csv and parquet hold the arrays; rrd is for Rerun; mcap adds to the log (or, with --to, to
    a copy) what Foxglove draws. A run that draws figures has done the latter already.
    """
    from equipoise.analysis.export_run import export_run

    path, note = export_run(run_folder, kind, to)
    _tell_note(note)
    click.echo(path)


@cli.command()
@click.argument("name", required=False)
@click.argument("file", required=False)
@click.option("--path", "only_path", is_flag=True, help="Print only the URDF's path.")
def robots(name: str | None, file: str | None, only_path: bool) -> None:
    """List the robots, or show what is known of NAME (a robot, or its URDF, YAML or folder).

    `equipoise robots new my.urdf > my.yaml` guesses soles, feet, palms, fingers and half-sitting of
    a URDF or MJCF, for you to correct.
    """
    from equipoise.console import print_robot, print_robots
    from equipoise.robots import get_robot, named_robots, robot_urdf_path

    if name == "new":
        from equipoise.robots.guess import guess_yaml

        if file is None:
            raise InputError("robots new needs a file", remedy="equipoise robots new my.urdf")
        click.echo(guess_yaml(file), nl=False)
    elif file is not None:
        raise InputError("one robot at a time", given=f"{name} {file}")
    elif name is None:
        if only_path:
            raise InputError("--path needs a robot", known=named_robots())
        print_robots(named_robots())
    elif only_path:
        click.echo(robot_urdf_path(name))
    else:
        print_robot(get_robot(name))


@cli.command()
@click.argument("name", required=False)
@click.option("--robot", metavar="ROBOT", help="Refit it to this robot (a name or a file).")
def scenarios(name: str | None, robot: str | None) -> None:
    """List the scenarios, or print NAME with every default written out."""
    from equipoise.scenarios import named_scenarios, read_scenario, resolved_text

    if name is not None:
        click.echo(resolved_text(read_scenario(name, robot=robot)), nl=False)
        return
    for key in named_scenarios():
        click.echo(f"{key:<20}{read_scenario(key).title}")


@cli.command()
@click.argument("urdf", type=click.Path(path_type=Path))
def check(urdf: Path) -> None:
    """Check a robot (URDF, YAML or folder) before it is trusted: every finding and its remedy."""
    from equipoise.robots import check_urdf

    findings = check_urdf(urdf)
    for finding in findings:
        click.echo(f"{finding.severity}: {finding}")
    errors = sum(finding.severity == "error" for finding in findings)
    warnings = sum(finding.severity == "warning" for finding in findings)
    name = urdf.resolve().name if urdf.is_dir() else urdf
    click.echo(f"{name}: {_count(errors, 'error')}, {_count(warnings, 'warning')}")
    sys.exit(WRONG_INPUT if errors else PASSED)


@cli.command()
@click.argument("run_folder", metavar="[RUN]", required=False, type=click.Path(path_type=Path))
@click.option("--robot", metavar="URDF", help="Show a robot (a name or a file) instead of a run.")
@page_options
@click.option("--no-browser", is_flag=True, help="Open no browser.")
def view(
    run_folder: Path | None, robot: str | None, address: tuple[str, int | None], no_browser: bool
) -> None:
    """Show RUN (or the last one under runs/) in the browser: picture, time line, plots.

    Example: equipoise view runs/latest --port 9000
    """
    if robot is not None and run_folder is not None:
        raise InputError("a run and a robot cannot be shown at once", given=str(run_folder))
    from equipoise.viewer.commands import view_robot, view_run

    if robot is not None:
        view_robot(robot, *address, click.echo, browse=not no_browser)
    else:
        view_run(run_folder, *address, click.echo, browse=not no_browser)


@cli.command()
@click.argument("robot", default="hrp2", metavar="[ROBOT]")
@page_options
@click.option("--no-browser", is_flag=True, help="Open no browser.")
@click.option(
    "--physics",
    type=click.Choice(["rigid", "mujoco"]),
    help="The engine that moves the robot: mujoco where it is installed.",
)
@click.option("--reference-only", is_flag=True, help="Move the reference: no law, no engine.")
def play(
    robot: str,
    address: tuple[str, int | None],
    no_browser: bool,
    physics: Literal["rigid", "mujoco"] | None,
    reference_only: bool,
) -> None:
    """Drag the hands of ROBOT (a name or a file) in the browser, and see what stops them.

    The whole controller runs: push the robot, load it, take the friction from its floor.

    Example: equipoise play talos
    """
    from equipoise.viewer.commands import play as play_robot

    play_robot(
        robot,
        *address,
        click.echo,
        browse=not no_browser,
        physics=physics,
        reference_only=reference_only,
    )


@cli.command()
@click.argument(
    "run_folders", metavar="RUN...", nargs=-1, required=True, type=click.Path(path_type=Path)
)
@click.option(
    "--to", type=click.Path(path_type=Path), default=Path("report.html"), show_default=True
)
def report(run_folders: tuple[Path, ...], to: Path) -> None:
    """Write one HTML file about one or several RUNs, side by side, that needs no network."""
    from equipoise.analysis.report.page import make_report

    click.echo(make_report(run_folders, to, told=_tell_note))


@cli.command()
@click.argument("place", metavar="RUN|FILE.npz", type=click.Path(path_type=Path))
@click.option("--at", "t", type=float, metavar="T", help="Time of the run to explain [s].")
@click.option("--task", "tasks", multiple=True, metavar="NAME", help="Explain only this task.")
@click.option("--details", is_flag=True, help="Also say how far each bound would have to move.")
@click.option("--save", type=click.Path(path_type=Path), help="Write the hierarchy to this file.")
def explain(
    place: Path, t: float | None, tasks: tuple[str, ...], details: bool, save: Path | None
) -> None:
    """Say which tasks were not met at time T of RUN, which rows blocked them and by how much.

    A hierarchy that --save wrote can be explained (and is solved) again without the run.
    Example: equipoise explain runs/latest --at 4.2 --details
    """
    from equipoise.analysis.explain_run import explain_file, explain_tick

    if place.suffix == ".npz":
        if t is not None:
            raise InputError("a saved hierarchy has no time", given=t, remedy="Leave out --at")
        lines = explain_file(place, tasks, details=details, save=save)
    else:
        lines = explain_tick(place, t, tasks, details=details, save=save)
    for line in lines:
        click.echo(line)


@cli.command()
@click.option("--robot", "robots", multiple=True, metavar="ROBOT", help="Robot [hrp2]; repeatable.")
@click.option("--json", "to", type=click.Path(path_type=Path), help="Write the rows to this file.")
@click.option("--compare", "kept", type=click.Path(path_type=Path), help="Kept rows.")
@click.option("--peer-python", "pythons", multiple=True, metavar="NAME=PATH", help="See below.")
@click.option("--quick", is_flag=True, help="A few ticks: shows that it works, measures nothing.")
@click.option("--growth", "grows", is_flag=True, help="Also how time grows with the problem.")
@click.option("--memory", type=click.IntRange(min=100), metavar="TICKS", help="Only: does it grow?")
def bench(
    robots: tuple[str, ...],
    to: Path | None,
    kept: Path | None,
    pythons: tuple[str, ...],
    quick: bool,
    grows: bool,
    memory: int | None,
) -> None:
    """Time the tick, its parts and every peer that is installed, in turns in one process.

    PlaCo and TSID need a Python of their own: --peer-python placo=PATH. With --compare it ends
    with 1 if a ratio of ours to another's is worse than the kept one by more than a third.
    Example: equipoise bench --robot hrp2 --robot talos --json rows.json
    """
    from equipoise.bench.threads import pin_threads

    pin_threads()
    from equipoise.bench.command import bench_memory, bench_times

    names = robots or ("hrp2",)
    if memory is not None:
        passed = bench_memory(names, memory)
    else:
        passed = bench_times(names, pythons, quick=quick, grows=grows, to=to, kept=kept)
    sys.exit(PASSED if passed else NOT_PASSED)


@cli.command()
@click.argument(
    "run_folders", metavar="RUN...", nargs=-1, required=True, type=click.Path(path_type=Path)
)
@click.option("--to", type=click.Path(path_type=Path), help="File to write [RUN/video.mp4].")
@click.option("--camera", default="quarter", show_default=True, metavar="NAME",
              help="quarter, front, side, hands or follow.")  # fmt: skip
@click.option("--size", default="960x540", show_default=True, metavar="WxH", help="Pixels of each.")
@click.option("--speed", type=float, default=1.0, show_default=True, help="2: twice as fast.")
@click.option("--fps", type=click.IntRange(1, 120), default=25, show_default=True)
@click.option("--arrows/--no-arrows", default=True, help="Forces, wanted ones beside them.")
@click.option("--captions/--no-captions", default=True)
@click.option("--still", type=float, metavar="T", help="One picture at T [s], as PNG, instead.")
def render(run_folders: tuple[Path, ...], to: Path | None, size: str, **asked: Any) -> None:
    """Make an MP4 film of RUN, or of several side by side, without a display.

    Example: equipoise render runs/latest --camera hands --speed 0.5
    """
    from equipoise.analysis.render_run import render_runs
    from equipoise.console import Progress
    from equipoise.runlog import load_run

    loaded = [load_run(folder) for folder in run_folders]
    for one in loaded:
        _tell_note(one.note)
    with Progress() as progress:
        click.echo(render_runs(loaded, to, size, asked, lambda share: progress("drawing", share)))


@cli.command()
@click.argument("groups", nargs=-1, metavar="[GROUP...]")
@click.option("--json", "as_json", is_flag=True, help="Print the table as JSON.")
def verify(groups: tuple[str, ...], as_json: bool) -> None:
    """Measure every equation and claim of the paper against the code.

    GROUP: geometry, motion, dynamics, law, promises, metric, switch; all of them by default.
    Exit code 0 only if every row holds.
    """
    from equipoise.verify import GROUPS
    from equipoise.verify import verify as measure
    from equipoise.verify.table import as_text, print_verdict, print_verdicts

    chosen = groups or tuple(GROUPS)
    verdicts = measure(chosen, report=None if as_json else print_verdict)
    if as_json:
        click.echo(as_text(verdicts))
    else:
        print_verdicts(verdicts)
    sys.exit(PASSED if all(verdict.holds for verdict in verdicts) else NOT_PASSED)


def _count(number: int, what: str) -> str:
    return f"{number} {what}" if number == 1 else f"{number} {what}s"


def _tell_note(note: str) -> None:
    """Say what is missing of a log, or wrong with it, on the side where no numbers go."""
    if note:
        click.echo(f"Note: {note}", err=True)


def main() -> None:
    """Run the command line; errors of the user become one message and exit code 2."""
    for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
        os.environ.setdefault(variable, "1")  # small matrices: threads only cost
    try:
        cli(standalone_mode=False)
    except click.exceptions.Abort:
        sys.exit(INTERRUPTED)
    except click.ClickException as error:
        error.show()
        sys.exit(WRONG_INPUT)
    except EquipoiseError as error:
        click.echo(f"equipoise: {error}", err=True)
        sys.exit(WRONG_INPUT)
    except KeyboardInterrupt:
        sys.exit(INTERRUPTED)
    except OSError as error:
        if error.filename is None:
            raise
        click.echo(f"equipoise: {error.filename}: {error.strerror}.", err=True)
        sys.exit(WRONG_INPUT)


if __name__ == "__main__":
    main()
