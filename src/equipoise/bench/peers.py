"""The peers by name: where each comes from, how it is made, and what it leaves out."""

from __future__ import annotations

import importlib
import importlib.util
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from equipoise.bench.interleave import Contender
from equipoise.bench.problem import Problem
from equipoise.errors import InputError, NameNotFoundError

_LEVELS = "strict levels (weights instead), balance, gaze, contact forces, the torque law"


@dataclass(frozen=True)
class Peer:
    """A peer: the module to import, its package, and what it does not do of our tick.

    `apart` peers cannot be imported beside us and run in a Python that the user names.
    """

    module: str
    package: str
    leaves_out: str
    apart: bool = False


PEERS: Mapping[str, Peer] = {
    "pink": Peer("pink", "pin-pink", f"{_LEVELS}; collisions"),
    "pink_collisions": Peer("pink", "pin-pink", _LEVELS),
    "mink": Peer("mink", "mink", f"{_LEVELS}; collisions"),
    "mink_collisions": Peer("mink", "mink", _LEVELS),
    "placo": Peer(
        "placo", "placo", "balance, gaze, collisions, contact forces, the torque law", apart=True
    ),
    "tsid": Peer(
        "tsid",
        "tsid",
        "strict inequalities below the first level, gaze, collisions, position limits; it needs "
        "the dynamic model, and gives torques with it",
        apart=True,
    ),
}


def make_peers(
    problem: Problem,
    pythons: Mapping[str, str],
    ticks: int,
    say: Callable[[str], None],
) -> list[Contender]:
    """Return the peers that can be had; `say` is told which cannot, and why.

    `pythons` names a Python for peers that run apart; one that is named must work.
    Raises: `NameNotFoundError`, `InputError`.
    """
    check_pythons(pythons)
    found: list[Contender] = []
    for name, peer in PEERS.items():
        if peer.apart:
            if name not in pythons:
                say(f"{name} is left out: name a Python that has it, --peer-python {name}=PATH")
                continue
            from equipoise.bench.subprocess_peer import ApartPeer

            found.append(ApartPeer(problem, name, pythons[name], ticks))
        elif missing_of(peer):
            say(f"{name} is left out: pip install {peer.package} (or equipoise[bench])")
        else:
            found.append(_beside(name, problem))
    return found


def check_pythons(pythons: Mapping[str, str]) -> None:
    """Refuse a Python for a peer that is unknown, or that is imported beside us."""
    apart = [name for name, peer in PEERS.items() if peer.apart]
    for name in pythons:
        if name not in PEERS:
            raise NameNotFoundError("peer", name, apart)
        if name not in apart:
            raise InputError(
                f"{name} is imported beside Equipoise and needs no Python of its own",
                given=f"{name}={pythons[name]}",
                known=apart,
                remedy=f"pip install {PEERS[name].package}",
            )


def parse_pythons(texts: Sequence[str]) -> dict[str, str]:
    """Return name -> path of texts `NAME=PATH`. Raises: `InputError`."""
    found = {}
    for text in texts:
        name, sign, path = text.partition("=")
        if not (name and sign and path):
            raise InputError(
                "a peer's Python has the form NAME=PATH",
                given=text,
                remedy="For example --peer-python placo=/home/me/placo/bin/python",
            )
        found[name] = path
    check_pythons(found)
    return found


def missing_of(peer: Peer) -> bool:
    """Say whether the module of a peer is not installed."""
    return importlib.util.find_spec(peer.module) is None


def _beside(name: str, problem: Problem) -> Contender:
    collisions = name.endswith("_collisions")
    if name.startswith("pink"):
        from equipoise.bench.pink_peer import PinkPeer

        return PinkPeer(problem, collisions=collisions)
    from equipoise.bench.mink_peer import MinkPeer

    return MinkPeer(problem, collisions=collisions)
