"""The engine `cores`: a process a core; one that ends is replaced, its batch begun again."""

from __future__ import annotations

import os
import subprocess
import sys
from collections import deque
from collections.abc import Sequence
from contextlib import suppress
from multiprocessing import Pipe
from multiprocessing.connection import Connection, wait

from equipoise.studies.batch import Batch
from equipoise.studies.engines.base import DiskFullError, EngineLostError, Told
from equipoise.studies.engines.serve import COMPILED, DISK, OVER, READY
from equipoise.studies.plan import StudyRun

THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")
LAST_WORDS = 2000  # characters of what a worker said before it ended
MOST_DEATHS = 3  # of workers that did not even become ready


class _Worker:
    """A process, its pipe, and the batch it works on."""

    def __init__(self, study: str, runs: tuple[StudyRun, ...], modules: Sequence[str]) -> None:
        ours, theirs = Pipe()
        paths = os.pathsep.join(filter(None, sys.path))
        environment = {**os.environ, "PYTHONPATH": paths, **dict.fromkeys(THREADS, "1")}
        self.process = subprocess.Popen(
            [sys.executable, "-m", f"{__package__}.serve", str(theirs.fileno()), *modules],
            pass_fds=[theirs.fileno()],
            stdin=subprocess.DEVNULL,
            env=environment,
        )
        theirs.close()
        self.pipe: Connection = ours
        self.ready, self.batch = False, None  # type: tuple[bool, Batch | None]
        self.pipe.send((study, runs))

    def end(self) -> None:
        """Kill it."""
        self.process.kill()
        self.process.wait()
        self.pipe.close()


class Cores:
    """Processes of this machine. `runs` are tried for a few ticks so that kernels are compiled."""

    waiting_most = 1.0

    def __init__(
        self,
        workers: int | None,
        study: str,
        runs: tuple[StudyRun, ...],
        modules: Sequence[str] = (),
    ) -> None:
        self.slots = workers or len(os.sched_getaffinity(0))
        self._study, self._modules = study, modules
        self._queue: deque[Batch] = deque()
        self._unready_deaths = 0
        # alone until it is known that all kernels are there; what then comes need not look
        self._workers = [_Worker(study, runs, modules)]

    def _new(self) -> _Worker:
        return _Worker(self._study, (), self._modules)

    @property
    def processes(self) -> list[int]:
        """The ids of the processes."""
        return [worker.process.pid for worker in self._workers]

    def submit(self, batch: Batch) -> None:
        """Have a batch done as soon as a process is free."""
        self._queue.append(batch)
        self._give_out()

    def wait(self, seconds: float) -> list[Told]:
        """Return what happened. Raises: `DiskFullError`, `EngineLostError`."""
        told = []
        by_pipe = {worker.pipe: worker for worker in self._workers}
        for pipe in wait(list(by_pipe), seconds):
            told += self._hear(by_pipe[pipe])  # type: ignore[index]
        self._give_out()
        return told

    def _hear(self, worker: _Worker) -> list[Told]:
        try:
            word, content = worker.pipe.recv()
        except (EOFError, OSError):
            return self._bury(worker)
        if word == READY:
            self._welcome(worker, compiled=content)
            return []
        batch = worker.batch
        assert batch is not None
        if word == DISK:
            raise DiskFullError(content)
        if word == COMPILED:
            self._bury(worker)
            return []
        if word == OVER:
            worker.batch = None
            return [Told(batch, over=True)]
        return [Told(batch, (content,))]

    def _welcome(self, worker: _Worker, *, compiled: bool) -> None:
        """Take a worker that is ready, or a fresh one in its place if it had to compile kernels."""
        self._unready_deaths = 0
        if compiled:
            worker.end()
            self._workers[self._workers.index(worker)] = self._new()
            return
        worker.ready = True
        while len(self._workers) < self.slots:
            self._workers.append(self._new())

    def _bury(self, worker: _Worker) -> list[Told]:
        """Replace a worker that ended; what it was at goes to the next one."""
        worker.end()
        if not worker.ready:
            self._unready_deaths += 1
            if self._unready_deaths >= MOST_DEATHS:
                raise EngineLostError(
                    f"{MOST_DEATHS} worker processes ended before they began to work "
                    f"(the last one with {worker.process.returncode})"
                )
        self._workers[self._workers.index(worker)] = self._new()
        if worker.batch is None:
            return []
        self._queue.appendleft(worker.batch)
        return [Told(worker.batch, lost=True)]

    def _give_out(self) -> None:
        for worker in self._workers:
            if self._queue and worker.ready and worker.batch is None:
                worker.batch = self._queue.popleft()
                with suppress(OSError):  # it ended: heard next, and the batch goes to another
                    worker.pipe.send(worker.batch)

    def close(self) -> None:
        """End all processes, at once."""
        for worker in self._workers:
            worker.end()
        self._workers, self._queue = [], deque()
