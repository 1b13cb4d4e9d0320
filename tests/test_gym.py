"""The Gymnasium environment: its checker is content, and wanting the goal gets there."""

from __future__ import annotations

import subprocess
import sys
import warnings

import numpy as np
import pytest

from equipoise.contacts import SurfaceContact
from equipoise.errors import InputError
from equipoise.robots import get_robot

gymnasium = pytest.importorskip("gymnasium")
from gymnasium.utils.env_checker import check_env  # noqa: E402

from equipoise.gym import Episode, WholeBodyEnv  # noqa: E402


def pressing(**episode) -> WholeBodyEnv:
    """Return HRP-2 with a wall before its left palm, which the agent presses."""
    robot = get_robot("hrp2")
    kin = robot.at(robot.q_half_sitting)
    wall = SurfaceContact.on_plane("wall", "left_palm", kin, normal=(-1.0, 0.0, 0.0))
    return WholeBodyEnv(robot, contacts=[wall], episode=Episode(**episode))


def test_gymnasiums_own_checker_is_content() -> None:
    made = gymnasium.make("equipoise/Reach-v0", episode=Episode(ticks=5))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_env(made.unwrapped, skip_render_check=True)
        check_env(pressing(ticks=5), skip_render_check=True)


def test_to_want_the_goal_is_to_get_there() -> None:
    """The rest is the controller's: hand and force come to what the agent wants of them."""
    env = pressing(steps=60)
    env.reset(seed=3)
    action = np.concatenate(
        (env.goal / env.episode.way, np.zeros(3), 2.0 * env.wanted / env.episode.force - 1.0)
    )
    cut, rewards = False, []
    while not cut:
        _, reward, off, cut, info = env.step(action)
        rewards.append(reward)
        assert not off
    assert len(rewards) == 60
    assert info["t"] == pytest.approx(1.2)
    assert info["distance"] < 1e-3
    assert rewards[-1] > -0.02 > rewards[0]


def test_the_same_seed_and_actions_give_the_same_bits() -> None:
    env = pressing()
    actions = np.random.default_rng(0).uniform(-1.0, 1.0, (6, *env.action_space.shape))
    runs = []
    for _ in range(2):
        seen = [env.reset(seed=11)[0]]
        seen += [env.step(action)[0] for action in actions]
        runs.append(np.array(seen))
    assert np.array_equal(*runs)
    assert all(env.observation_space.contains(row) for row in runs[0])


def test_a_fixed_arm_in_mujoco_reaches() -> None:
    pytest.importorskip("mujoco")
    from equipoise.robots import named_robots

    if missing := named_robots()["baxter"].missing:
        pytest.skip(f"baxter is not installed: {missing}")
    episode = Episode(engine="mujoco", steps=50)
    env = WholeBodyEnv("baxter", ("left_palm", "right_palm"), episode=episode)
    env.reset(seed=1, options={"goal": [0.0, 0.0, 0.08]})
    lift = np.tile([0.0, 0.0, 0.8, 0.0, 0.0, 0.0], 2)
    for _ in range(50):
        *_, off, _, info = env.step(lift)
        assert not off
    assert info["distance"] < 0.005


def test_what_cannot_be_is_refused() -> None:
    with pytest.raises(InputError, match="whole number"):
        Episode(ticks=2.5)
    with pytest.raises(InputError, match="no engine"):
        Episode(engine="bullet")
    with pytest.raises(InputError, match="hands are"):
        WholeBodyEnv("hrp2", "right_palm")


def test_it_is_imported_by_nobody_who_does_not_ask() -> None:
    code = "import sys, equipoise, equipoise.wbc; print('gymnasium' in sys.modules)"
    answer = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert answer.stdout.strip() == "False"


def test_without_gymnasium_it_says_what_to_install() -> None:
    code = "import sys; sys.modules['gymnasium'] = None; import equipoise.gym"
    answer = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert "equipoise[gym]" in answer.stderr
