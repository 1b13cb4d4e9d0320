"""The engine that a study asks for."""

from __future__ import annotations

from collections.abc import Sequence

from equipoise.errors import InputError
from equipoise.studies.engines.base import Engine
from equipoise.studies.engines.cores import Cores
from equipoise.studies.plan import StudyRun
from equipoise.studies.schema import StudySpec


def make_engine(
    study: StudySpec, runs: tuple[StudyRun, ...], modules: Sequence[str] = ()
) -> Engine:
    """Return the engine; `runs` are examples of what will run. Raises: `InputError`."""
    spec = study.engine
    if spec.kind == "cores":
        if spec.address is not None:
            raise InputError(
                "an address belongs to a Dask cluster",
                given=spec.address,
                remedy="Say engine: {kind: dask, address: ...}",
            )
        return Cores(spec.workers, study.model_dump_json(), runs, modules)
    from equipoise.studies.engines.dask_cluster import DaskCluster

    return DaskCluster(spec, study.model_dump_json(), runs, modules)
