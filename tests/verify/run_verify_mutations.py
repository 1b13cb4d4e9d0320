"""Break each equation in a copy of the code and see that `equipoise verify` notices.

By hand: `python tests/verify/run_verify_mutations.py [beginning of a name ...]`; some ten
seconds a mutation. Prints which rows noticed; exit code 1 if a mutation survived.
"""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from verify_mutations import MUTATIONS, Mutation

import equipoise

PACKAGE = Path(equipoise.__file__).parent


def rows_that_notice(mutation: Mutation, root: Path) -> list[str]:
    """Return the keys of the rows that fail under a mutation in the copy at `root`."""
    path = root / "equipoise" / mutation.file
    text = path.read_text(encoding="utf-8")
    if mutation.before not in text:
        raise SystemExit(f"{mutation.equation}: {mutation.file} has no {mutation.before!r}")
    path.write_text(text.replace(mutation.before, mutation.after, 1), encoding="utf-8")
    try:
        done = subprocess.run(
            [sys.executable, "-m", "equipoise", "verify", "--json", mutation.group],
            env={**os.environ, "PYTHONPATH": str(root), "OMP_NUM_THREADS": "1"},
            capture_output=True,
            text=True,
        )
    finally:
        path.write_text(text, encoding="utf-8")
    return [row["key"] for row in json.loads(done.stdout)["rows"] if not row["holds"]]


def main() -> int:
    """Run the chosen mutations, or all; return how many survived."""
    chosen = [
        m for m in MUTATIONS if not sys.argv[1:] or m.equation.startswith(tuple(sys.argv[1:]))
    ]
    survived = 0
    with tempfile.TemporaryDirectory() as folder:
        root = Path(folder)
        shutil.copytree(PACKAGE, root / "equipoise")
        for mutation in chosen:
            keys = rows_that_notice(mutation, root)
            survived += not keys
            print(f"{mutation.equation:<40} {', '.join(keys) or 'SURVIVED'}", flush=True)
    return survived


if __name__ == "__main__":
    sys.exit(1 if main() else 0)
