"""Compiled code is kept only in a folder that is the user's alone."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest

from equipoise.compiled.own_folder import own_folder


def test_a_new_folder_is_the_users_alone(tmp_path):
    path = tmp_path / "deep" / "equipoise"
    assert own_folder(path) == ""
    assert path.stat().st_mode & 0o777 == 0o700
    assert own_folder(path) == ""


@pytest.mark.parametrize("mode", [0o777, 0o770, 0o702])
def test_a_folder_that_others_write_into_is_not_trusted(tmp_path, mode):
    path = tmp_path / "equipoise"
    path.mkdir()
    path.chmod(mode)
    assert "others can write" in own_folder(path)


def test_nor_is_one_below_such_a_folder_unless_that_is_sticky(tmp_path):
    above = tmp_path / "shared"
    above.mkdir()
    above.chmod(0o777)
    assert "shared" in own_folder(above / "equipoise")
    above.chmod(0o1777)
    assert own_folder(above / "equipoise") == ""


def test_a_link_is_followed_before_it_is_judged(tmp_path):
    target, link = tmp_path / "open", tmp_path / "equipoise"
    target.mkdir()
    target.chmod(0o777)
    link.symlink_to(target)
    assert "others can write" in own_folder(link)


@pytest.mark.skipif(os.geteuid() != 0, reason="only root can give a folder away")
def test_another_users_folder_is_not_trusted(tmp_path):
    path = tmp_path / "equipoise"
    path.mkdir(mode=0o700)
    os.chown(path, 12345, 12345)
    assert "another user" in own_folder(path)


def test_what_cannot_be_a_folder_is_told(tmp_path):
    (tmp_path / "file").write_text("")
    assert "cannot be used" in own_folder(tmp_path / "file" / "equipoise")


def test_kernels_run_without_a_folder_and_leave_nothing_in_it(tmp_path):
    kept = tmp_path / "equipoise"
    kept.mkdir()
    kept.chmod(0o777)
    code = "from equipoise.trajectories import Travel; print(Travel(0.0, 1.0, 2.0)(0.5)[0])"
    done = subprocess.run(
        [sys.executable, "-c", code],
        env={**os.environ, "NUMBA_CACHE_DIR": str(tmp_path)},
        capture_output=True,
        text=True,
        check=True,
    )
    assert float(done.stdout) == pytest.approx(1.0)
    assert done.stderr.count("Compiled code is not kept") == 1
    assert list(kept.iterdir()) == []
