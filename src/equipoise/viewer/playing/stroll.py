"""A stroll: a robot that is played with comes to walk, is steered, and stands again."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pinocchio as pin

from equipoise.contacts import ContactStack, SoleContact
from equipoise.hqp import make_solver
from equipoise.kinematics import Kinematics
from equipoise.motion import MotionGenerator
from equipoise.robots import Robot
from equipoise.robots.measures import measure
from equipoise.robots.registry import get_robot
from equipoise.scenarios import read_scenario, schema
from equipoise.simulation.build.rehearse import STEP, least_room, moments_of
from equipoise.simulation.build.walk import WalkSetup, make_walk
from equipoise.simulation.sensors import Reading
from equipoise.simulation.walk import Ground, WalkDriver
from equipoise.spatial import Array
from equipoise.tasks import JointLimitsTask, PostureTask, Task
from equipoise.walking import SteeredWalk, Stick, StickSchedule
from equipoise.walking.feet import Stance
from equipoise.walking.pieces import derivative, move, value
from equipoise.wbc import WholeBodyController

SCENARIO = "steered_walk"  # from which lengths, times and rates are taken
LIMITS_RATE, POSTURE_RATE = 20.0, 2.0  # [1/s]
OVERSHOOT = 0.005  # [m] by which the zero-moment point may pass the goal of the way to the start
LEAST = 1.0  # [s] of that way
RESTS = 0.3  # [s] that it stands, let go, before the hands are led again


def walk_spec(robot: Robot) -> schema.WalkSpec:
    """Return how a robot walks: as in the scenario, with lengths that go with its height."""
    scenario = read_scenario(SCENARIO)
    spec = scenario.walk
    assert spec is not None
    old, new = measure(get_robot(scenario.robot)), measure(robot)
    legs, stance = new.height / old.height, new.stance / old.stance
    stride = {
        "forward": legs * spec.stride.forward,
        "side": legs * spec.stride.side,
    }
    return spec.model_copy(
        update={
            "steer": [],
            "crouch": legs * spec.crouch,
            "margin": stance * spec.margin,
            "inward": stance * spec.inward,
            "swing": spec.swing.model_copy(update={"height": legs * spec.swing.height}),
            "stride": spec.stride.model_copy(update=stride),
        }
    )


class Stroll:
    """Leads a walk from where a robot stands, its reference at `kin`, on feet as they stand.

    At first the centre of mass goes to where a walk begins, and the trunk becomes upright; `begin`
    tells the controller that runs, `before_tick` leads on. The arms stay as they are.
    Raises: `InputError` for what cannot be walked.
    """

    def __init__(
        self, robot: Robot, spec: schema.WalkSpec, feet: Sequence[SoleContact], kin: Kinematics
    ) -> None:
        self.robot, self.contacts = robot, ContactStack(feet)
        self.walk: WalkSetup = make_walk(spec, robot, self.contacts)
        self._driver: WalkDriver | None = None
        self._start, self._rested = 0.0, 0.0
        self._q_posture = self._posture(kin)
        height = self.walk.planner.settings.height
        here, there = np.array(kin.p_world_com), self.walk.targets.centre.row(0.0)[9:12].copy()
        way = float(np.linalg.norm((there - here)[:2]))
        self._duration = max(LEAST, float(np.sqrt(5.77 * way * height / (9.81 * OVERSHOOT))))
        self._centre = move(here, there, self._duration)
        self._trunk = []
        for frame, led in self.walk.targets.upright.items():
            R, goal = kin.placement(frame).rotation.copy(), led.at(0.0).T_world_target.rotation
            turn = R @ pin.log3(R.T @ goal)  # world axes
            self._trunk.append((led, R, move(np.zeros(3), turn, self._duration)))
        self._approach(0.0)

    @property
    def walker(self) -> SteeredWalk | None:
        """Who makes the footsteps, once it walks."""
        return None if self._driver is None else self._driver.steered

    @property
    def stance(self) -> Stance:
        """Where the feet stand, or stood last."""
        return self.walk.plan.stance if self._driver is None else self._driver.walker.stance

    @property
    def carrying(self) -> tuple[str, ...]:
        """Names of the feet that carry."""
        if self._driver is None:
            return self.walk.contacts
        return tuple(self.walk.contacts[foot] for foot in self._driver.walker.supports)

    @property
    def over(self) -> bool:
        """Whether it stands again, and the stick was let go."""
        return self._rested > RESTS

    @property
    def sentence(self) -> str:
        """What it does, in words."""
        steered = self.walker
        if steered is None:
            return "It gets ready to walk."
        clip = f" {steered.clip[:1].upper()}{steered.clip[1:]}." if steered.clip else ""
        return steered.sentence + clip

    def levels(self) -> list[list[Task]]:
        """Return the levels of a walk."""
        robot, walk = self.robot, self.walk
        return [
            walk.feet_tasks(),
            [JointLimitsTask("limits", robot, rate=LIMITS_RATE)],
            [walk.com_task()],
            walk.trunk_tasks(),
            [PostureTask("posture", robot, self._q_posture, rate=POSTURE_RATE)],
        ]

    def begin(self, t: float, controller: WholeBodyController, ground: Ground) -> None:
        """Take note of what runs from time `t` [s] on."""
        self._start, self._controller, self._ground = t, controller, ground

    def before_tick(self, t: float, stick: Stick, reading: Reading) -> None:
        """Lead on to the tick of time `t` [s]."""
        s = t - self._start
        if s < self._duration:
            self._approach(s)
            return
        if self._driver is None:
            self._driver = WalkDriver(
                self.walk, self.robot, self.contacts, self._controller, self._ground
            )
        driver, steered = self._driver, self._driver.steered
        assert steered is not None
        driver.steer(stick)
        driver.before_tick(t, reading)
        stands = driver.walker.stands and not stick.held
        self._rested = self._rested + self._controller.dt if stands else 0.0

    def rehearse(self, q: Array, fastest: Stick) -> tuple[float, float]:
        """Walk forwards, round a bend and sideways in mind, from the reference `q` (nq,).

        Returns how far [m] a foot or the centre of mass would be behind, and how far [m] inside its
        soles the zero-moment point of the whole robot would stay. Nothing else may be done with
        this stroll.
        """
        motion = MotionGenerator(
            self.robot, self.levels(), lambda: make_solver("active_set"), STEP, q, advise=False
        )
        for k in range(round(self._duration / STEP)):
            self._approach(k * STEP)
            motion.step(0.0)
        period = self.walk.planner.period
        ways = (Stick(fastest.forward), Stick(turn=fastest.turn), Stick(left=-fastest.left))
        moments = [(2.0 * k * period, way) for k, way in enumerate(ways)]
        end = self.walk.planner.settings.timing.shift + 2.0 * (len(ways) + 1) * period
        found = moments_of(motion, self.walk, end, StickSchedule(moments))
        room, _ = least_room(self.robot, self.walk, found)
        return max(one.behind for one in found), room

    def _approach(self, s: float) -> None:
        """Lead centre of mass and trunk to where a walk begins, `s` [s] after they left."""
        speed = value(derivative(self._centre), s)
        self.walk.targets.centre.write_point(value(self._centre, s), speed)
        for led, R, turn in self._trunk:
            T = pin.SE3(pin.exp3(value(turn, s)) @ R, np.zeros(3))
            led.write(T, np.r_[np.zeros(3), value(derivative(turn), s)])

    def _posture(self, kin: Kinematics) -> Array:
        """Return the joints (na,) that it comes back to: half-sitting legs, all else as it is."""
        base = self.robot.nq_base
        q = np.array(kin.q)[base:].copy()
        for sole in self.walk.planner.feet.soles:
            legs = list(self.robot.joints_between(sole.frame))
            q[legs] = self.robot.q_half_sitting[base:][legs]
        return q
