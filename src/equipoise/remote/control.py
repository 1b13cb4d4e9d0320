"""What `equipoise control` does before its run: the robot is met and looked at."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial

from equipoise.remote.bring_up import BroughtUp
from equipoise.remote.drive import RemoteRun
from equipoise.remote.options import WireOptions
from equipoise.remote.realtime import claim_machine, release_machine
from equipoise.remote.signals import StopSignals
from equipoise.scenarios import Scenario
from equipoise.wire.interface import (
    RobotInterface,
)
from equipoise.wire.session import RecordingRobot, SessionRobot

Say = Callable[[str], None]


def control_robot(scenario: Scenario, options: WireOptions, say: Say) -> RemoteRun:
    """Return a run whose robot was met, looked at and found good; nothing was commanded yet.

    From then on Ctrl-C and SIGTERM let the run ramp out; the second of them ends it at once.
    Raises: `RobotLostError`, `InputError`, `ScenarioError`.
    """
    signals = StopSignals()
    signals.take()
    try:
        run = RemoteRun(scenario, options.connect, lockstep=options.lockstep)
    except BaseException:
        signals.give_back()
        raise
    run.released = signals.give_back
    try:
        for sentence in run.meet():
            say(sentence)
        for link in _chain(run.link):
            if isinstance(link, BroughtUp) and link.told:
                say(link.told)
            if isinstance(link, SessionRobot) and link.damage:
                say(link.damage)
        if not options.lockstep:
            for sentence in claim_machine():
                say(sentence)
        run.released = partial(_released, run, options, signals)
        run.ramp_out.asked = signals.asked
    except BaseException:
        run.close()
        raise
    return run


def _chain(link: RobotInterface) -> Iterator[RobotInterface]:
    """Yield a link, what is behind it, and so on."""
    behind: RobotInterface | None = link
    while behind is not None:
        yield behind
        behind = getattr(behind, "behind", None)


def _released(run: RemoteRun, options: WireOptions, signals: StopSignals) -> None:
    """Be a program like any other again, and tell what is known of sessions."""
    signals.give_back()
    if not options.lockstep:
        release_machine()
    for link in _chain(run.link):
        if isinstance(link, SessionRobot):
            run.tell(link.sentence())
        if isinstance(link, RecordingRobot) and link.trouble:
            run.tell(link.trouble)
