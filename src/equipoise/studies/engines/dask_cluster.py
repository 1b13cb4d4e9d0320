"""The engine `dask`: batches as tasks of a cluster, released as soon as their results are here."""

from __future__ import annotations

import time
from collections.abc import Sequence
from importlib import import_module
from queue import Empty, SimpleQueue
from typing import Any
from urllib.parse import urlsplit

from equipoise.errors import InputError
from equipoise.studies.batch import Batch, CompiledError, work_on
from equipoise.studies.engines.base import DiskFullError, EngineLostError, Told
from equipoise.studies.engines.serve import warm_up
from equipoise.studies.journal import Result
from equipoise.studies.plan import StudyRun
from equipoise.studies.provenance import source_hash
from equipoise.studies.runner import LOST, failed
from equipoise.studies.schema import EngineSpec, TlsSpec

HERE = {"127.0.0.1", "localhost", "::1"}
FRESH = 5.0  # [s] after which the number of workers is looked up again
PATIENCE = 120.0  # [s] to wait for the first worker
REMEDY = "pip install 'equipoise[study]'"
CLUSTERS = {
    "slurm": ("dask_jobqueue", "SLURMCluster", "pip install dask-jobqueue"),
    "kubernetes": ("dask_kubernetes.operator", "KubeCluster", "pip install dask-kubernetes"),
}


class DaskCluster:
    """A Dask cluster, joined or made. Raises: `InputError` if it cannot be had as it is asked for.

    Workers have one thread each and run the same code as the client.
    """

    waiting_most = 2.0  # one worked on, one at hand: a worker never waits for the client

    def __init__(
        self,
        spec: EngineSpec,
        study: str,
        runs: tuple[StudyRun, ...],
        modules: Sequence[str] = (),
    ) -> None:
        distributed = _library()
        if spec.address:
            check_address(spec.address, spec.tls)
        self._news: SimpleQueue[Any] = SimpleQueue()
        self._batches: dict[str, Batch] = {}
        try:
            self._cluster = None if spec.address else _made(spec)
        except (RuntimeError, OSError) as error:  # a TimeoutError is an OSError
            raise EngineLostError(f"the Dask cluster did not start: {error}") from error
        try:
            self._client = distributed.Client(
                self._cluster or spec.address, security=security_of(spec.tls), timeout=PATIENCE
            )
        except OSError as error:
            raise InputError(
                f"no Dask scheduler answers: {error}",
                given=spec.address,
                remedy="Start one with  dask scheduler --host 127.0.0.1 --no-dashboard",
            ) from None
        self._slots, self._looked = 0, -FRESH
        try:
            self._greet(study, runs, modules)
        except BaseException:
            self.close()
            raise

    def _greet(self, study: str, runs: tuple[StudyRun, ...], modules: Sequence[str]) -> None:
        """Wait for a worker, see that all are as wanted, and have kernels compiled beforehand."""
        client = self._client
        try:
            client.wait_for_workers(1, timeout=PATIENCE)
        except TimeoutError:
            raise InputError(
                f"the cluster has had no worker for {PATIENCE:.0f} s",
                remedy="Start some with  dask worker ADDRESS --nthreads 1",
            ) from None
        codes = set(client.run(source_hash).values())
        if codes != {source_hash()}:
            raise InputError(
                "the workers run another version of equipoise than this client",
                remedy="Install the same one everywhere",
            )
        threads = set(client.nthreads().values())
        if threads != {1}:
            raise InputError(
                "a worker must have one thread",
                given=sorted(threads),
                remedy="Start them with  dask worker ADDRESS --nthreads 1",
            )
        for module in modules:
            client.run(_import, module)
        one_a_host: dict[str, str] = {}
        for address in client.nthreads():
            one_a_host.setdefault(urlsplit(address).hostname or address, address)
        client.run(warm_up, study, runs, workers=list(one_a_host.values()))

    @property
    def slots(self) -> int:
        """How many workers there are."""
        now = time.monotonic()
        if now - self._looked > FRESH:
            self._slots, self._looked = len(self._client.nthreads()), now
        return self._slots

    def submit(self, batch: Batch) -> None:
        """Have a batch done by any worker."""
        self._batches[batch.name] = batch
        future = self._client.submit(_work, batch, key=batch.name, pure=False)
        future.add_done_callback(self._news.put)

    def wait(self, seconds: float) -> list[Told]:
        """Return which batches are done. Raises: `DiskFullError`, `EngineLostError`."""
        told: list[Told] = []
        try:
            told.append(self._heard(self._news.get(timeout=seconds)))
            while True:
                told.append(self._heard(self._news.get_nowait()))
        except Empty:
            if not told and self._client.status != "running":
                raise EngineLostError("the Dask scheduler is gone") from None
            return told

    def _heard(self, future: Any) -> Told:
        from distributed.scheduler import KilledWorker

        batch = self._batches.pop(future.key)
        try:
            results, kept = future.result()
        except KilledWorker as error:
            return Told(batch, self._killed(batch, str(error)), kept=False, over=True, lost=True)
        except CompiledError as error:
            self._client.restart_workers([error.args[0]], raise_for_error=False)
            return Told(batch, over=True)
        except OSError as error:
            raise DiskFullError(error.strerror or str(error)) from error
        except Exception as error:
            raise EngineLostError(f"the Dask cluster gave up: {error}") from error
        finally:
            future.release()  # a held result is made again when its worker ends
        return Told(batch, tuple(results), kept=kept, over=True)

    def _killed(self, batch: Batch, why: str) -> tuple[Result, ...]:
        """Return the result of the run that ended several workers; of more, each goes alone."""
        return (failed(batch.runs[0], LOST, why),) if len(batch.runs) == 1 else ()

    def close(self) -> None:
        """Leave the cluster; end it if it was made for this study."""
        self._client.close()
        if self._cluster is not None:
            self._cluster.close()


def security_of(tls: TlsSpec | None) -> Any:
    """Return what Dask wants to know about certificates."""
    if tls is None:
        return None
    return _library().Security(
        tls_ca_file=tls.ca,
        tls_client_cert=tls.cert,
        tls_client_key=tls.key,
        require_encryption=True,
    )


def check_address(address: str, tls: TlsSpec | None) -> None:
    """Refuse a scheduler on another machine that is not spoken to by TLS. Raises: `InputError`.

    Whoever can reach a Dask scheduler can run any code on its workers.
    """
    parts = urlsplit(address if "//" in address else f"tcp://{address}")
    if parts.hostname in HERE:
        return
    if parts.scheme != "tls" or tls is None:
        raise InputError(
            "a scheduler on another machine is only spoken to by TLS",
            given=address,
            remedy="Give an address tls://... and the files tls: {ca, cert, key}",
        )


def _made(spec: EngineSpec) -> Any:
    """Return a cluster for this study alone. Raises: `InputError`."""
    if spec.cluster == "local":
        distributed = _library()
        return distributed.LocalCluster(
            n_workers=spec.workers,
            threads_per_worker=1,
            host="127.0.0.1",
            dashboard_address=None,
            **spec.options,
        )
    module, name, remedy = CLUSTERS[spec.cluster]
    try:
        kind = getattr(import_module(module), name)
    except ImportError:
        raise InputError(
            f"{spec.cluster} needs {module.partition('.')[0]}", remedy=remedy
        ) from None
    options: dict[str, Any] = dict(spec.options)
    if spec.cluster == "slurm":  # encrypted, with certificates of its own, and no dashboard
        options = {"cores": 1, "processes": 1, "security": True, "protocol": "tls://"} | options
        options.setdefault("scheduler_options", {"dashboard": False})
    cluster = kind(**options)
    cluster.scale(spec.workers or 1)
    return cluster


def _library() -> Any:
    try:
        import dask
        import distributed
    except ImportError:
        raise InputError("the engine dask needs distributed", remedy=REMEDY) from None
    dask.config.set(
        {
            "distributed.scheduler.allowed-failures": 3,
            "distributed.comm.timeouts.connect": f"{PATIENCE:.0f}s",  # a busy machine is slow
        }
    )
    return distributed


def _work(batch: Batch) -> tuple[list[Result], bool]:
    """Do a batch on a worker, which says who it is if it should not be used any more."""
    from distributed import get_worker

    try:
        return work_on(batch)
    except CompiledError:
        raise CompiledError(get_worker().address) from None


def _import(module: str) -> None:
    import_module(module)
