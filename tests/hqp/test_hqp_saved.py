"""A hierarchy in a file comes back as it was, and a damaged file gives a sentence."""

from __future__ import annotations

import json
import math
import zipfile

import numpy as np
import pytest
from hqp_problems import KINDS, random_hierarchy

from equipoise.errors import InputError
from equipoise.hqp import (
    Hierarchy,
    RowDescription,
    explain,
    load_problem,
    make_solver,
    plain_descriptions,
    save_problem,
    saved,
)


@pytest.mark.parametrize("kind", KINDS)
def test_solved_again_it_gives_the_same_bits_and_the_same_words(kind, tmp_path) -> None:
    h = random_hierarchy(kind, 5, n=9)
    words = tuple(
        RowDescription(f"m{r}/s", f"up {r}", f"down {r}", 1.0 + r) for r in range(len(h.lower))
    )
    save_problem(tmp_path / "h.npz", h, words=words, note="from a test")
    back = load_problem(tmp_path / "h.npz")
    assert back.note == "from a test"
    assert [repr(w) for w in back.words] == [repr(w) for w in words]
    v, again = (make_solver("cascade").solve(x).v for x in (h, back.hierarchy))
    assert np.array_equal(v, again)
    assert str(explain(h, v, words)) == str(explain(back.hierarchy, again, back.words))


def test_without_words_the_names_are_the_words(tmp_path) -> None:
    h = random_hierarchy("infeasible", 2)
    save_problem(tmp_path / "h.npz", h)
    back = load_problem(tmp_path / "h.npz")
    assert [w.above for w in back.words] == [w.above for w in plain_descriptions(h)]
    assert all(math.isnan(w.rate_above) for w in back.words)


def test_levels_without_rows_survive(tmp_path) -> None:
    h = Hierarchy.stack([[], [], []], 4)
    save_problem(tmp_path / "h.npz", h)
    back = load_problem(tmp_path / "h.npz").hierarchy
    assert (back.ends, back.A.shape) == (h.ends, (0, 4))


def test_no_damage_gets_through_unnoticed(tmp_path) -> None:
    """Any byte changed, any length cut: the same problem (a byte nobody reads) or a sentence."""
    h = random_hierarchy("boxes", 2, n=5)
    path = tmp_path / "h.npz"
    save_problem(path, h)
    whole = path.read_bytes()
    rng = np.random.default_rng(0)
    refused = 0
    for trial in range(400):
        damaged = bytearray(whole)
        if trial % 4:
            for _ in range(trial % 4):
                damaged[rng.integers(len(damaged))] ^= 1 << int(rng.integers(8))
        else:
            del damaged[rng.integers(len(damaged)) :]
        path.write_bytes(damaged)
        try:
            back = load_problem(path).hierarchy
        except InputError:
            refused += 1
        else:
            assert np.array_equal(back.A, h.A)
            assert np.array_equal(back.lower, h.lower)
            assert back.blocks == h.blocks
    assert refused > 300


def rewritten(path, change) -> None:
    """Write the file again with sound checksums and other content."""
    with np.load(path, allow_pickle=False) as file:
        arrays = {name: file[name] for name in ("A", "lower", "upper")}
        about = json.loads(str(file["about"]))
    change(arrays, about)
    np.savez(path, about=np.array(json.dumps(about)), **arrays)


def _put(place, key, value):
    place[key] = value


LIES = {
    "format": lambda arrays, about: _put(about, "format", 99),
    "fewer rows": lambda arrays, about: _put(arrays, "lower", arrays["lower"][:-1]),
    "no blocks": lambda arrays, about: _put(about, "blocks", []),
    "level": lambda arrays, about: _put(about["blocks"][0], 3, 7),
    "levels": lambda arrays, about: _put(about, "levels", 10**9),
    "levels, a text": lambda arrays, about: _put(about, "levels", "two"),
    "NaN": lambda arrays, about: _put(arrays["A"], (0, 0), np.nan),
    "bounds": lambda arrays, about: _put(arrays, "lower", arrays["upper"] + 1.0),
    "complex": lambda arrays, about: _put(arrays, "A", arrays["A"] + 1j),
    "text": lambda arrays, about: _put(arrays, "A", arrays["A"].astype(str)),
    "flat": lambda arrays, about: _put(arrays, "A", arrays["A"].ravel()),
    "words": lambda arrays, about: _put(about, "words", [["m/s", "a", "b", 1.0, 1.0]]),
    "rates": lambda arrays, about: _put(
        about, "words", [["m", "a", "b", "x", {}]] * len(arrays["A"])
    ),
    "no note": lambda arrays, about: about.pop("note"),
}  # fmt: skip


@pytest.mark.parametrize("lie", LIES)
def test_a_file_that_contradicts_itself_is_refused(lie, tmp_path) -> None:
    path = tmp_path / "h.npz"
    save_problem(path, random_hierarchy("infeasible", 3, n=5))
    rewritten(path, LIES[lie])
    with pytest.raises(InputError, match=r"--save"):
        load_problem(path)


def test_a_pickle_is_never_opened(tmp_path) -> None:
    path = tmp_path / "h.npz"
    np.savez(path, A=np.array([{"a": 1}], dtype=object), lower=[], upper=[], about="{}")
    with pytest.raises(InputError):
        load_problem(path)


def test_a_bomb_is_not_unpacked(tmp_path, monkeypatch) -> None:
    path = tmp_path / "h.npz"
    monkeypatch.setattr(saved, "BYTES_MAX", 1 << 22)
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("A.npy", bytes(1 << 23))
    assert path.stat().st_size < 1 << 14
    with pytest.raises(InputError, match="unpacks to"):
        load_problem(path)


def test_other_places_are_told_apart(tmp_path) -> None:
    for place in (tmp_path / "none.npz", tmp_path):
        with pytest.raises(InputError, match="cannot be read"):
            load_problem(place)
    (tmp_path / "text.npz").write_text("levels: 3")
    with pytest.raises(InputError, match="damaged"):
        load_problem(tmp_path / "text.npz")
    with pytest.raises(InputError, match="cannot be written"):
        save_problem(tmp_path / "no" / "h.npz", random_hierarchy("boxes", 2))
