"""What the controller is not told: payloads, sensors that err, faults."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, model_validator

from equipoise.scenarios.schema.base import NotNegative, Positive, Section, Vector3


class PayloadSpec(Section):
    """An unknown mass [kg] at a point of an object or of a frame; the controller is not told."""

    mass: Positive
    object: str | None = None
    frame: str | None = None
    at: Vector3 = [0.0, 0.0, 0.0]

    @model_validator(mode="after")
    def _one_place(self) -> PayloadSpec:
        if (self.object is None) == (self.frame is None):
            raise ValueError("give exactly one of object and frame")
        return self


class LinkScaleSpec(Section):
    """Factors on the true `mass` and `inertia` of what a joint moves."""

    mass: Positive = 1.0
    inertia: Positive = 1.0


class DisturbancesSpec(Section):
    """What the simulated robot has and the controller does not know.

    `links`: factors by the name of a link; everything fixed to the link takes part. `com_shift`
    [m], base axes: where the robot's centre of mass is at half-sitting, besides where it should be;
    the mass of every link lies that far off.
    """

    payloads: list[PayloadSpec] = []
    mass_scale: Positive = 1.0
    links: dict[str, LinkScaleSpec] = {}
    com_shift: Vector3 = [0.0, 0.0, 0.0]


class SensorSpec(Section):
    """Errors of one kind of sensor, in its unit.

    `noise`: standard deviation a tick; `bias`: standard deviation of a constant drawn once;
    `filter_time` [s] of a first-order low pass; `delay` [s], rounded up to whole ticks.
    """

    noise: NotNegative = 0.0
    bias: NotNegative = 0.0
    filter_time: NotNegative = 0.0
    delay: NotNegative = 0.0


class SilenceSpec(Section):
    """A sensor that says nothing new from `start` on, until `end` if that is given.

    `sensor`: joint_position, joint_velocity, base, a joint or a contact. `reading`: `nan` gives
    none, `frozen` repeats the last value.
    """

    sensor: str
    start: NotNegative
    end: NotNegative | None = None
    reading: Literal["nan", "frozen"] = "nan"


class SensorsSpec(Section):
    """What is measured of the true state. Units: rad, rad/s, m, m/s, N, N m."""

    joint_position: SensorSpec = SensorSpec()
    joint_velocity: SensorSpec = SensorSpec()
    base_position: SensorSpec = SensorSpec()
    base_angle: SensorSpec = SensorSpec()
    base_velocity: SensorSpec = SensorSpec()
    base_rate: SensorSpec = SensorSpec()
    force: SensorSpec = SensorSpec()
    moment: SensorSpec = SensorSpec()


class ExternalForceSpec(Section):
    """A `force` [N], world axes, at the origin of `frame` for `duration` [s] from `start` on."""

    frame: str
    force: Vector3
    start: NotNegative
    duration: Positive


class VanishingSpec(Section):
    """A fixed `body` of the world is gone from time `at` [s] on, and what stood on it falls."""

    body: str
    at: NotNegative


class FaultsSpec(Section):
    """What goes wrong on purpose.

    `measurement_delay` and `command_delay` [s] are rounded up to whole ticks. `missed_ticks`:
    probability that a control tick comes one period late. `torque_share`: share of each torque
    limit that the motors still give. `silences`: sensors that are lost. `vanishing`: bodies that
    give way.
    """

    pushes: list[ExternalForceSpec] = []
    measurement_delay: NotNegative = 0.0
    command_delay: NotNegative = 0.0
    missed_ticks: Annotated[float, Field(ge=0.0, lt=1.0)] = 0.0
    torque_share: Annotated[float, Field(ge=0.0, le=1.0)] = 1.0
    silences: list[SilenceSpec] = []
    vanishing: list[VanishingSpec] = []
