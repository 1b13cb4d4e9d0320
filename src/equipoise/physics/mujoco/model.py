"""The MuJoCo model of a robot in its world, made from the same objects as every other engine."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import ModuleType
from typing import Any

from equipoise.contacts import ContactStack
from equipoise.errors import InputError, one_line
from equipoise.kinematics import Kinematics
from equipoise.physics.mujoco.contact_pads import PadSensor, add_floor, add_pad_bodies, add_pads
from equipoise.physics.mujoco.conversion import FollowerPlace, StateConversion
from equipoise.physics.mujoco.names import of_joint
from equipoise.physics.mujoco.objects import Surroundings
from equipoise.physics.mujoco.options import MujocoOptions
from equipoise.physics.mujoco.robot_model import add_link_shapes, add_robot
from equipoise.physics.mujoco.world_model import add_fixed, add_loose
from equipoise.robots import Robot


@dataclass(frozen=True)
class MujocoModel:
    """A compiled model, where our joints are in it, and the pads' sensors.

    `xml` is the model as MJCF, to look at or to run elsewhere.
    """

    compiled: Any
    conversion: StateConversion
    sensors: tuple[PadSensor, ...]
    spec: Any

    @property
    def joint_names(self) -> tuple[str, ...]:
        """Names of the robot's actuated joints, in the order of ours."""
        model = self.compiled
        names = {int(model.jnt_dofadr[j]): model.joint(j).name for j in range(model.njnt)}
        ours = (names[int(dof)] for dof in self.conversion.dof_joints)
        return tuple(name.removeprefix(of_joint("")) for name in ours)


def build_model(
    mujoco: ModuleType,
    robot: Robot,
    contacts: ContactStack,
    start: Kinematics,
    surroundings: Surroundings,
    options: MujocoOptions,
    step: float,
    pushing: Mapping[str, str],
) -> MujocoModel:
    """Return the model; `step` [s] is the physics step, `start` the kinematics of the first state.

    Raises: `InputError` for what MuJoCo cannot be given.
    """
    spec = mujoco.MjSpec()
    spec.modelname = robot.name
    _set_options(mujoco, spec, options, step)
    bodies = add_robot(mujoco, spec, robot, options)
    pads = add_pad_bodies(mujoco, spec, robot, bodies, contacts)
    touchless = {robot.model.frames[frame_id].parentJoint for frame_id in pads}
    add_link_shapes(mujoco, spec, robot, bodies, touchless)
    add_pads(mujoco, spec, contacts, pads, pushing, start, options)
    _add_light(mujoco, spec)
    if surroundings.floor_height is not None:
        add_floor(mujoco, spec.worldbody, surroundings.floor_height, options)
    for body in surroundings.fixed:
        add_fixed(mujoco, spec, body)
    for loose in surroundings.loose:
        add_loose(mujoco, spec, loose, robot, pads, options)
    try:
        compiled = spec.compile()
    except (ValueError, RuntimeError, TypeError, mujoco.FatalError) as error:
        raise InputError(
            f"MuJoCo cannot be given robot {robot.name} in this world: {one_line(error)}",
            remedy="Look for masses, inertias or sizes far from those of real bodies",
        ) from error
    return MujocoModel(
        compiled, _conversion(compiled, robot), tuple(PadSensor(f) for f in pads), spec
    )


def _set_options(mujoco: ModuleType, spec: Any, options: MujocoOptions, step: float) -> None:
    spec.compiler.degree = False
    spec.compiler.autolimits = False
    spec.option.timestep = step
    spec.option.gravity = list(options.gravity)
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    spec.option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    spec.option.impratio = 10.0
    # Regularised friction creeps: a standing foot turned by 3 mrad in 3 s. This takes it out.
    spec.option.noslip_iterations = 5
    # MuJoCo 4.0.0 factorises sparse constraint Jacobians wrongly (mended in 4.0.1): stay dense.
    spec.option.jacobian = mujoco.mjtJacobian.mjJAC_DENSE
    # A reset would hide a divergence: we read the warnings instead.
    spec.option.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_AUTORESET)


def _add_light(mujoco: ModuleType, spec: Any) -> None:
    """Add a sun, and let the camera's own light soften the shadows; only pictures see them."""
    spec.worldbody.add_light(
        type=mujoco.mjtLightType.mjLIGHT_DIRECTIONAL,
        pos=[1.5, -1.0, 3.0],
        dir=[-0.4, 0.3, -1.0],
        castshadow=True,
    )
    spec.visual.headlight.ambient = [0.45, 0.45, 0.45]
    spec.visual.headlight.diffuse = [0.35, 0.35, 0.35]


def _conversion(compiled: Any, robot: Robot) -> StateConversion:
    joints = [compiled.joint(of_joint(name)).id for name in robot.joint_names]
    followers = []
    for name, (leader, ratio, offset) in robot.followers.items():
        joint = compiled.joint(of_joint(name)).id
        places = int(compiled.jnt_qposadr[joint]), int(compiled.jnt_dofadr[joint])
        followers.append(FollowerPlace(*places, robot.joint_index(leader), ratio, offset))
    return StateConversion(
        compiled.jnt_qposadr[joints], compiled.jnt_dofadr[joints], floating=robot.nv_base > 0
    ).with_followers(followers)
