"""The tables of a comparison, and how they are written as text, HTML and LaTeX."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from html import escape

import numpy as np

from equipoise.studies.compare.boundaries import Bracket, brackets, value_on
from equipoise.studies.compare.pairs import sampled_rows
from equipoise.studies.compare.statistics import Share, mcnemar, paired_difference, share
from equipoise.studies.compare.units import metric_label, parameter_label, scaled, spoke_name
from equipoise.studies.results import Results


@dataclass(frozen=True)
class Table:
    """A table: its title, names of columns, rows of texts, and a note below it."""

    title: str
    columns: Sequence[str]
    rows: Sequence[Sequence[str]]
    note: str = ""


def all_tables(results: Results, baseline: str) -> list[Table]:
    """Return the tables that a study has results for."""
    tables = [success(results), against(results, baseline), differences(results, baseline)]
    tables += [margins(results, name) for name in results.designs(["boundary"])
               if getattr(results.study.designs[name], "along", "") == "each"]  # fmt: skip
    tables += [causes(results), tick_times(results)]
    return [table for table in tables if table.rows]


def success(results: Results) -> Table:
    """Return how many runs stand and are good, with the medians of what was measured."""
    rows_of = sampled_rows(results)
    metrics = shown_metrics(results)
    rows = []
    for name, rows_here in rows_of.items():
        stands, good = results["stands"][rows_here], results["good"][rows_here]
        cells = [name, _share(share(stands)), _share(share(good))]
        standing = rows_here[stands.astype(bool)]
        cells += [_median(scaled(metric, results[f"m.{metric}"][standing])) for metric in metrics]
        rows.append(cells)
    count = len(next(iter(rows_of.values()), ()))
    return Table(
        f"Success on {count} paired points",
        ["controller", "stands", "good", *(metric_label(metric) for metric in metrics)],
        rows if count else [],
        "Brackets: 95 % intervals (Wilson). Medians of the runs that stand, in brackets the 90th "
        "percentile.",
    )


def against(results: Results, baseline: str) -> Table:
    """Return exact tests of every other controller against one, on pairs."""
    rows_of = sampled_rows(results)
    rows = []
    for name, rows_here in rows_of.items():
        if name == baseline or not len(rows_here):
            continue
        for what in ("stands", "good"):
            test = mcnemar(results[what][rows_of[baseline]], results[what][rows_here])
            counts = (test.both, test.only_first, test.only_second, test.neither)
            rows.append([name, what, *map(str, counts), _p(test.p)])
    return Table(
        f"Pairs against {baseline}",
        ["controller", "what", "both", f"only {baseline}", "only it", "neither", "p"],
        rows,
        "p: exact McNemar test, two-sided.",
    )


def differences(results: Results, baseline: str) -> Table:
    """Return by how much others differ from one where both stand."""
    rows_of, rows = sampled_rows(results), []
    for name, rows_here in rows_of.items():
        if name == baseline or not len(rows_here):
            continue
        first = rows_of[baseline]
        both = results["stands"][first].astype(bool) & results["stands"][rows_here].astype(bool)
        for metric in shown_metrics(results):
            column = scaled(metric, results[f"m.{metric}"])
            found = paired_difference(column[first[both]], column[rows_here[both]])
            low, middle, high = found.quartiles
            cells = [f"{middle:+.3g}", f"{low:+.3g} to {high:+.3g}", str(found.count)]
            rows.append([name, metric_label(metric), *cells, _p(found.p)])
    return Table(
        f"Paired differences to {baseline} where both stand",
        ["controller", "metric", "median", "quartiles", "pairs", "p"],
        rows,
        "Negative: smaller than the other. p: Wilcoxon signed ranks, two-sided.",
    )


def margins(results: Results, design: str) -> Table:
    """Return up to which value of each parameter, alone, a run is good."""
    found = brackets(results, design)
    names = list(dict.fromkeys(one.line.name for one in found))
    rows = []
    for name in names:
        parameter = name[:-1]
        word = spoke_name(results.study, name).partition(" ")[0]
        label = parameter_label(results.study, parameter)
        cells = [f"{label}, {word}" if word in ("more", "less") else label]
        for controller in results.controllers:
            here = [b for b in found if b.line.name == name and b.controller == controller]
            cells.append(_margin(results, here[0], parameter) if here else "")
        rows.append(cells)
    return Table(
        "Margins: good up to, each parameter alone",
        ["parameter", *results.controllers],
        rows,
        "Last good and first not good value of the bisection; > is good to the end of the range.",
    )


def _margin(results: Results, bracket: Bracket, parameter: str) -> str:
    if np.isnan(bracket.low):
        return "not at nominal"
    if np.isnan(bracket.high):
        return f"> {value_on(results, bracket, 1.0, parameter):.3g}"
    ends = (value_on(results, bracket, share, parameter) for share in (bracket.low, bracket.high))
    return " to ".join(f"{value:.3g}" for value in ends)


def causes(results: Results) -> Table:
    """Return why runs were not good, by controller."""
    found = causes_of(results)
    rows = [[cause, *(str(counts.get(name, 0)) for name in results.controllers)]
            for cause, counts in found.items()]  # fmt: skip
    return Table("Why runs were not good", ["cause", *results.controllers], rows)


def causes_of(results: Results) -> dict[str, dict[str, int]]:
    """Return how often each cause was met by each controller on paired points, most often first."""
    counts: dict[str, dict[str, int]] = {}
    for name, rows in sampled_rows(results).items():
        for cause in results["cause"][rows]:
            if cause:
                mine = counts.setdefault(str(cause), {})
                mine[name] = mine.get(name, 0) + 1
    return dict(sorted(counts.items(), key=lambda item: (-sum(item[1].values()), item[0])))


def tick_times(results: Results) -> Table:
    """Return how long a tick of motion and control takes, by controller."""
    rows = []
    for name in results.controllers:
        mask = results["controller"] == name
        if "tick_median_us" not in results.times:
            break
        median, tail = (results.times[f"tick_{kind}_us"][mask] for kind in ("median", "p99"))
        rows.append([name, _median(median), _median(tail)])
    return Table(
        "A tick of motion and control",
        ["controller", "median [us]", "99th percentile [us]"],
        rows,
        "Median over the runs, in brackets the 90th percentile. Measured while all workers ran.",
    )


def shown_metrics(results: Results) -> list[str]:
    """Return the metrics with numbers that are no 0 or 1, those that are bounded first."""
    wanted = [*results.study.good, *results.study.metrics]
    return [m for m in dict.fromkeys(wanted) if f"m.{m}" in results.columns]


def _share(found: Share) -> str:
    return f"{found.count}/{found.of} ({found.low:.2f} to {found.high:.2f})"


def _median(values: np.ndarray) -> str:
    values = values[np.isfinite(values)]
    if not len(values):
        return "-"
    return f"{np.median(values):.3g} ({np.percentile(values, 90):.3g})"


def _p(value: float) -> str:
    if np.isnan(value):
        return "-"
    return f"{value:.3f}" if value >= 0.001 else f"{value:.1e}"


def as_text(table: Table) -> str:
    """Return a table as lines of text."""
    rows = [list(table.columns), *map(list, table.rows)]
    widths = [max(len(row[k]) for row in rows) for k in range(len(table.columns))]
    lines = [
        "  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip()
        for row in rows
    ]
    rule = "-" * max(map(len, lines))
    return "\n".join([table.title, lines[0], rule, *lines[1:], table.note]).rstrip()


def as_html(table: Table) -> str:
    """Return a table as HTML."""
    head = "".join(f"<th>{escape(column)}</th>" for column in table.columns)
    body = "".join(
        "<tr>" + "".join(f"<td>{escape(cell)}</td>" for cell in row) + "</tr>" for row in table.rows
    )
    note = f"<p class='soft'>{escape(table.note)}</p>" if table.note else ""
    return f"<h2>{escape(table.title)}</h2><table><tr>{head}</tr>{body}</table>{note}"


def as_latex(table: Table) -> str:
    """Return a table as LaTeX that needs no package."""
    head = " & ".join(map(_tex, table.columns))
    body = "\n".join(" & ".join(map(_tex, row)) + r" \\" for row in table.rows)
    return "\n".join(
        [
            r"\begin{table}",
            r"\centering",
            rf"\caption{{{_tex(f'{table.title}. {table.note}'.strip())}}}",
            rf"\begin{{tabular}}{{l{'r' * (len(table.columns) - 1)}}}",
            r"\hline",
            head + r" \\",
            r"\hline",
            body,
            r"\hline",
            r"\end{tabular}",
            r"\end{table}",
        ]
    )


_TEX = {"\\": r"\textbackslash{}", "~": r"\textasciitilde{}", "^": r"\textasciicircum{}",
        "µ": r"$\mu$", ">": "$>$", "<": "$<$", "±": r"$\pm$"}  # fmt: skip
_TEX |= {c: rf"\{c}" for c in "&%$#_{}"}


def _tex(text: str) -> str:
    return "".join(_TEX.get(c, c) for c in text)
