"""What a person reads who made a slip in a study: file and line, what exists, what to do."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest
from short import TEXT, short

from equipoise.errors import InputError
from equipoise.scenarios.gains_file import gains_overrides, gains_text, read_gains
from equipoise.studies.engines.dask_cluster import CLUSTERS, check_address, security_of
from equipoise.studies.engines.make import make_engine
from equipoise.studies.read import named_studies, read_study
from equipoise.studies.runner import Runner
from equipoise.studies.schema import TlsSpec


def said(folder: Path, text: str, *overrides: str) -> str:
    file = folder / "mine.yaml"
    file.write_text(text)
    with pytest.raises(InputError) as refused:
        Runner(read_study(str(file), overrides)).check()
    return str(refused.value)


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("log_uniform: [0.7, 1.4]", "log_uniform: [1.4, 0.7]", "line 9, parameters.mass: log_unif"),
        ("points: 4", "pionts: 4", "line 12, designs.main.pionts: unknown key"),
        ("along: mass", "along: mas", "there is no parameter 'mas'; known: mass, delay"),
        ("scenario: press", "scenario: pres", "There is no scenario 'pres'"),
        ("base_error:", "base_eror:", "There is no metric 'base_eror'"),
        ("control.gains.alpha: 5.0", "control.kind: idqb", "controllers.slow: control.kind: There"),
        ("control.gains.alpha: 5.0", "control.gains.alhpa: 5", "controllers.slow: control.gains.a"),
        ("disturbances.mass_scale", "contacts.sole.x", "There is no contact 'sole'"),
        ("kind: sobol", "kind: soboll", "There is no kind 'soboll'"),
        ("nominal: 1.0", "nominal: one", "valid number"),
    ],
)
def test_a_slip_is_found_before_anything_runs(
    tmp_path: Path, old: str, new: str, words: str
) -> None:
    assert old in TEXT
    assert words in said(tmp_path, TEXT.replace(old, new))


def test_an_override_is_named(tmp_path: Path) -> None:
    assert said(tmp_path, TEXT, "seeds=0").startswith("--set seeds=0: ")


def test_a_name_that_is_no_study_gets_the_nearest() -> None:
    with pytest.raises(InputError, match="Did you mean 'payload_delay'"):
        read_study("payload_dealy")


def test_a_controller_is_chosen_by_its_name(tmp_path: Path) -> None:
    assert list(short(tmp_path, "only=[slow]").controllers) == ["slow"]
    with pytest.raises(InputError, match="only: There is no controller 'fast'"):
        short(tmp_path, "only=[fast]")


@pytest.mark.parametrize("name", named_studies())
@pytest.mark.parametrize("robot", ["hrp2", "talos", "g1"])
def test_shipped_studies_can_be_read_for_every_robot(name: str, robot: str) -> None:
    whole, small = (read_study(name, robot=robot, small=small) for small in (False, True))
    assert set(small.controllers) < set(whole.controllers)
    assert whole.robot == robot
    if name == "payload_delay":
        assert whole.parameters["load"].uniform == [0.01, 10.0 if robot == "hrp2" else 2.5]


@pytest.mark.parametrize("name", named_studies())
def test_the_small_forms_can_begin(name: str) -> None:
    Runner(read_study(name, small=True)).check()


def test_a_scheduler_elsewhere_is_only_spoken_to_by_tls() -> None:
    tls = TlsSpec(ca="ca.pem", cert="cert.pem", key="key.pem")
    for address in ("tcp://127.0.0.1:8786", "localhost:8786", "tls://[::1]:8786"):
        check_address(address, None)
    for address in ("tcp://10.0.0.3:8786", "10.0.0.3:8786", "tls://10.0.0.3:8786"):
        with pytest.raises(InputError, match="only spoken to by TLS"):
            check_address(address, None)
    with pytest.raises(InputError, match="only spoken to by TLS"):
        check_address("tcp://10.0.0.3:8786", tls)
    check_address("tls://10.0.0.3:8786", tls)


def test_certificates_require_encryption() -> None:
    pytest.importorskip("distributed")
    security = security_of(TlsSpec(ca="ca.pem", cert="cert.pem", key="key.pem"))
    assert security.require_encryption is True
    assert security.tls_ca_file == "ca.pem"


@pytest.mark.parametrize("cluster", CLUSTERS)
def test_a_cluster_that_is_not_installed_is_told(cluster: str, tmp_path: Path) -> None:
    pytest.importorskip("distributed")
    package = CLUSTERS[cluster][0].partition(".")[0]
    if package in sys.modules:
        pytest.skip("it is installed")
    spec = short(tmp_path, f"engine={{kind: dask, cluster: {cluster}}}")
    with pytest.raises(InputError, match=f"{cluster} needs {package}. pip install"):
        make_engine(spec, ())


def test_an_address_belongs_to_dask(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="belongs to a Dask cluster"):
        make_engine(short(tmp_path, "engine.address=x"), ())


def test_a_file_of_gains_sets_what_it_says_and_nothing_else(tmp_path: Path) -> None:
    file = tmp_path / "gains.yaml"
    values = {"control.gains.kappa": 81.25, "control.gains.sgn_p.kind": "tanh"}
    file.write_text(gains_text(values, ["found: by hand", 'says "x"']))
    assert read_gains(file) == values
    assert gains_overrides(file)[0] == "control.gains.kappa=81.25"
    controllers = f"controllers.slow={{gains: {file}, set: {{control.gains.kappa: 7.0}}}}"
    spec = short(tmp_path, controllers)
    assert spec.controllers["slow"].set == {**values, "control.gains.kappa": 7.0}
    file.write_text(gains_text({"faults.torque_share": 0.1}, []))
    with pytest.raises(InputError, match="gains belong to the section control"):
        read_gains(file)
    file.write_text("alpha: 3\n")
    with pytest.raises(InputError, match="wanted the key 'set'"):
        read_gains(file)
