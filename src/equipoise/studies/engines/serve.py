"""A worker process of the engine `cores`: takes batches from a pipe, tells each result at once.

`python -m equipoise.studies.engines.serve FD [MODULE ...]`; it ends with the process that began it.
"""

from __future__ import annotations

import ctypes
import os
import pickle
import signal
import subprocess
import sys
from importlib import import_module
from multiprocessing.connection import Connection

from equipoise.studies.plan import StudyRun

DIE_WITH_PARENT = 1  # PR_SET_PDEATHSIG, see prctl(2)
READY, RESULT, OVER, DISK, COMPILED = "ready", "result", "over", "disk", "compiled"


def serve(pipe: Connection) -> None:
    """Work until the pipe is closed: see whether kernels have to be compiled, then do batches."""
    from equipoise.studies.batch import CompiledError, compiles, work_on

    study, runs = pipe.recv()
    pipe.send((READY, compiles(study, runs)))
    while True:
        try:
            batch = pipe.recv()
        except EOFError:
            return
        try:
            work_on(batch, told=lambda result: pipe.send((RESULT, result)))
            pipe.send((OVER, None))
        except CompiledError:
            pipe.send((COMPILED, None))
            return
        except OSError as error:
            pipe.send((DISK, f"{error.strerror or error}"))
            return


def warm_up(study: str, runs: tuple[StudyRun, ...]) -> None:
    """Have the kernels of some runs compiled by a process of its own, which then ends."""
    program = (
        f"import sys, pickle; from {__name__} import warm; warm(*pickle.load(sys.stdin.buffer))"
    )
    subprocess.run(
        [sys.executable, "-c", program],
        input=pickle.dumps((study, runs)),
        env={**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, sys.path))},
        check=False,
    )


def warm(study: str, runs: tuple[StudyRun, ...]) -> None:
    """Run a few ticks of some runs."""
    from equipoise.studies.batch import compiles

    compiles(study, runs)


def main() -> None:
    """Serve the pipe whose number is given."""
    parent = os.getppid()
    ctypes.CDLL(None).prctl(DIE_WITH_PARENT, signal.SIGKILL)
    if os.getppid() != parent:
        return  # it was gone before the kernel knew
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is the client's affair
    for module in sys.argv[2:]:
        import_module(module)
    serve(Connection(int(sys.argv[1])))


if __name__ == "__main__":
    main()
