"""The commands `study`, `compare` and `tune`; each imports what it needs when it is called."""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import dataclass
from functools import wraps
from importlib import import_module
from pathlib import Path
from typing import Any

import click

PASSED, NOT_PASSED = 0, 1
STUDIES = Path("studies")


@dataclass(frozen=True)
class Form:
    """In which form a file is read: for which robot, small or whole, with which changes."""

    robot: str | None
    small: bool
    overrides: tuple[str, ...]

    def with_more(self, *more: str) -> tuple[str, ...]:
        """Return the changes with more of them."""
        return (*self.overrides, *more)


@dataclass(frozen=True)
class Where:
    """Where runs run: how many processes, or which cluster; what they import first."""

    workers: int | None
    address: str | None
    modules: tuple[str, ...]

    def begin(self) -> list[str]:
        """Import what is to be imported; return what the engine of a file is changed to."""
        for module in self.modules:
            import_module(module)
        changes = [] if self.workers is None else [f"engine.workers={self.workers}"]
        if self.address is not None:
            changes += ["engine.kind=dask", f"engine.address={self.address}"]
        return changes


def form_options(command: Callable[..., None]) -> Callable[..., None]:
    """Add in which form a file is read; the command gets it as `form`."""

    @click.option("--robot", metavar="ROBOT", help="For this robot.")
    @click.option("--small", is_flag=True, help="The small form of the file: few, short runs.")
    @click.option(
        "--set", "overrides", multiple=True, metavar="PATH=VALUE", help="Change it; repeatable."
    )
    @wraps(command)
    def with_form(
        *, robot: str | None, small: bool, overrides: tuple[str, ...], **given: Any
    ) -> None:
        command(form=Form(robot, small, overrides), **given)

    return with_form


def where_options(command: Callable[..., None]) -> Callable[..., None]:
    """Add where runs run; the command gets it as `where`."""

    @click.option("--workers", type=click.IntRange(min=1), help="How many processes [all cores].")
    @click.option("--dask", "address", metavar="ADDRESS", help="On the cluster of this scheduler.")
    @click.option(
        "--import", "modules", multiple=True, metavar="MODULE", help="Import it: own controllers."
    )
    @wraps(command)
    def with_where(
        *, workers: int | None, address: str | None, modules: tuple[str, ...], **given: Any
    ) -> None:
        command(where=Where(workers, address, modules), **given)

    return with_where


@click.command()
@click.argument("study", required=False, metavar="[STUDY]")
@click.option("--only", multiple=True, metavar="CONTROLLER", help="Only these; repeatable.")
@click.option("--out", type=click.Path(path_type=Path), help="Its folder [studies/NAME-...].")
@click.option("--no-report", is_flag=True, help="Write the tables only.")
@form_options
@where_options
def study(
    study: str | None,
    only: tuple[str, ...],
    out: Path | None,
    no_report: bool,
    form: Form,
    where: Where,
) -> None:
    """Run STUDY (a name or a YAML file): one scenario, many points, several controllers.

    The same command goes on where it was ended, by Ctrl-C, a kill or a power cut; what finished is
    not run again. Without STUDY the shipped ones are listed.

    \b
      equipoise study payload_delay --small
      equipoise study combined_faults --robot talos --workers 8
      equipoise study mine.yaml --set designs.main.points=512 --set seeds=3
    """
    from equipoise.studies.read import named_studies, read_study

    if study is None:
        for name in named_studies():
            click.echo(f"{name:<20}{read_study(name).title}")
        return
    from equipoise.studies.drive import run_study
    from equipoise.studies.progress import StudyProgress, duration

    chosen = [f"only=[{', '.join(only)}]"] if only else []
    changes = form.with_more(*where.begin(), *chosen)
    spec = read_study(study, changes, robot=form.robot, small=form.small)
    parts = (spec.name, form.robot, "small" if form.small else None)
    place = out or STUDIES / "-".join(part for part in parts if part)
    with StudyProgress() as progress:
        try:
            run_study(
                spec,
                place,
                report=progress,
                waiting=lambda: click.echo("Workers of an earlier call still work; waiting ..."),
                modules=where.modules,
            )
        except KeyboardInterrupt:
            progress.__exit__(None, None, None)
            last = progress.last
            if last is not None:
                click.echo(
                    f"\nInterrupted: {last.done} of {last.most} runs are kept in {place}. "
                    "The same command goes on.",
                    err=True,
                )
            raise
    last = progress.last
    if last is not None:
        click.echo(f"{last.done - last.before} runs in {duration(progress.spent)}")
    if not no_report:
        _report(place)
    click.echo(f"Study:   {place}")


def _report(place: Path) -> None:
    from equipoise.studies.compare.write import print_comparison, write_page

    print_comparison(place, click.echo)
    click.echo(f"Report:  {write_page(place)}")


@click.command()
@click.argument("study_folder", metavar="STUDY_DIR", type=click.Path(path_type=Path))
@click.option("--baseline", metavar="CONTROLLER", help="Others are compared with it [the first].")
@click.option("--html", is_flag=True, help="Write report.html.")
@click.option("--latex", is_flag=True, help="Write tables.tex.")
@click.option("--pdf", is_flag=True, help="Write page.pdf: one page like that of a paper.")
@click.option("--figures", is_flag=True, help="Write each figure as PDF and PNG.")
@click.option("--to", type=click.Path(path_type=Path), help="Folder [that of the study].")
def compare(
    study_folder: Path,
    baseline: str | None,
    html: bool,
    latex: bool,
    pdf: bool,
    figures: bool,
    to: Path | None,
) -> None:
    """Compare the controllers of a study that `equipoise study` has run.

    Prints success with 95 % intervals (Wilson) and exact tests on pairs (McNemar).
    Example: equipoise compare studies/payload_delay --html --pdf
    """
    from equipoise.studies.compare import write

    place = to or study_folder
    write.print_comparison(study_folder, click.echo, baseline)
    if html:
        click.echo(write.write_page(study_folder, place / "report.html", baseline))
    if latex:
        click.echo(write.write_latex(study_folder, place / "tables.tex", baseline))
    if figures:
        for path in write.write_figures(study_folder, place / "figures", baseline):
            click.echo(path)
    if pdf:
        click.echo(write.write_pdf(study_folder, place / "page.pdf", baseline))


@click.command()
@click.argument("tune_file", metavar="TUNE")
@click.option("--trials", type=click.IntRange(min=1), help="How many gains are tried.")
@click.option("--out", type=click.Path(path_type=Path), help="Its folder [tuned/NAME].")
@form_options
@where_options
def tune(tune_file: str, trials: int | None, out: Path | None, form: Form, where: Where) -> None:
    """Look for gains on an ensemble of runs, and judge them on others that they were not found on.

    TUNE is a name or a YAML file. Writes gains.yaml only if the gains found are better on the
    hold-out than those of the adviser; ends with 1 if they are not.
    Example: equipoise tune press_delay --trials 100 && equipoise run press --gains gains.yaml
    """
    from equipoise.studies.tune.read import read_tune
    from equipoise.studies.tune.search import tune as search

    changes = form.with_more(*where.begin(), *([] if trials is None else [f"trials={trials}"]))
    spec = read_tune(tune_file, changes, robot=form.robot, small=form.small)
    place = out or Path("tuned") / spec.name
    outcome = search(spec, place, say=click.echo, modules=where.modules)
    for line in outcome.sentences():
        click.echo(line)
    sys.exit(PASSED if outcome.better else NOT_PASSED)
