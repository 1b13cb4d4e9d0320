"""A network inside one process, with a time of its own, that loses, delays, doubles and spoils.

Both ends run in it as they run on sockets; the same seed gives the same session.
"""

from __future__ import annotations

import heapq
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from equipoise.errors import InputError
from equipoise.wire.datagrams import Address

Actor = Callable[[float], float | None]  # given the time, acts; returns when it acts again


@dataclass(frozen=True)
class NetworkFaults:
    """What happens to packets.

    `loss`, `double`, `spoil` are shares: packets that are lost, that come twice, in which a byte
    is changed; `garbage` is the share beside which a packet of random bytes is sent. Each takes
    from `delay[0]` to `delay[1]` [s], so that later ones may overtake. In `silences`, from and to
    [s], nothing is carried at all.
    """

    loss: float = 0.0
    double: float = 0.0
    spoil: float = 0.0
    garbage: float = 0.0
    delay: tuple[float, float] = (0.0, 0.0)
    silences: tuple[tuple[float, float], ...] = ()

    def __post_init__(self) -> None:
        for name in ("loss", "double", "spoil", "garbage"):
            if not 0.0 <= getattr(self, name) <= 1.0:
                raise InputError(f"{name} must be a share", given=getattr(self, name))
        if not 0.0 <= self.delay[0] <= self.delay[1] < np.inf:
            raise InputError("delay must be two times in order, not negative", given=self.delay)


class VirtualNetwork:
    """Carries packets between places and lets actors act, in order of its time `now` [s]."""

    def __init__(self, faults: NetworkFaults, seed: int) -> None:
        self.faults, self.now = faults, 0.0
        self._random = np.random.default_rng(seed)
        self._events: list[tuple[float, int, Callable[[], None]]] = []
        self._count = 0
        self._boxes: dict[Address, deque[tuple[bytes, Address]]] = {}

    def place(self, address: Address) -> VirtualDatagrams:
        """Return an end of the network at an address."""
        self._boxes[address] = deque()
        return VirtualDatagrams(self, address)

    def box(self, address: Address) -> deque[tuple[bytes, Address]]:
        """Return what has arrived at an address."""
        return self._boxes[address]

    def start(self, actor: Actor) -> None:
        """Let an actor act now, and again when it says."""
        self._let_act(actor, self.now)

    def _let_act(self, actor: Actor, at: float) -> None:
        def act() -> None:
            again = actor(self.now)
            if again is not None:
                self._let_act(actor, again)

        self._at(at, act)

    def carry(self, packet: bytes, sender: Address, to: Address) -> None:
        """Take a packet on its way, with what happens to it there."""
        faults, random = self.faults, self._random
        if any(start <= self.now < end for start, end in faults.silences):
            return
        if random.random() < faults.garbage:
            self._arrive(random.bytes(int(random.integers(0, 1500))), sender, to)
        if random.random() < faults.loss:
            return
        if random.random() < faults.spoil:
            spoiled = bytearray(packet)
            spoiled[int(random.integers(len(packet)))] ^= int(random.integers(1, 256))
            packet = bytes(spoiled)
        for _ in range(2 if random.random() < faults.double else 1):
            self._arrive(packet, sender, to)

    def _arrive(self, packet: bytes, sender: Address, to: Address) -> None:
        delay = float(self._random.uniform(*self.faults.delay))
        box = self._boxes.get(to)
        if box is not None:
            self._at(self.now + delay, lambda: box.append((packet, sender)))

    def _at(self, time: float, what: Callable[[], None]) -> None:
        self._count += 1
        heapq.heappush(self._events, (time, self._count, what))

    def run(self, until: float, enough: Callable[[], bool]) -> None:
        """Let time go on to `until` [s], or until it is `enough`."""
        while not enough():
            if not self._events or self._events[0][0] > until:
                self.now = max(self.now, until)
                return
            self.now, _, what = heapq.heappop(self._events)
            what()


class VirtualDatagrams:
    """An end of a virtual network, as `Datagrams`: who waits there lets time go on."""

    def __init__(self, network: VirtualNetwork, address: Address) -> None:
        self._network, self._address = network, address

    @property
    def address(self) -> Address:
        """Where it listens."""
        return self._address

    def now(self) -> float:
        """Return the time [s] of the network."""
        return self._network.now

    def wait(self, until: float) -> None:
        """Let time go on until something has arrived, or to `until` [s]."""
        box = self._network.box(self._address)
        self._network.run(until, lambda: bool(box))

    def take(self) -> tuple[bytes, Address] | None:
        """Return the next packet and where it comes from, None if there is none."""
        box = self._network.box(self._address)
        return box.popleft() if box else None

    def send(self, packet: bytes, to: Address) -> None:
        """Send a packet; it may be lost."""
        self._network.carry(packet, self._address, to)

    def close(self) -> None:
        """Nothing to do: what arrives is not taken any more."""
