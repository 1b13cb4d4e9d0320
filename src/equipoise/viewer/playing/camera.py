"""A camera that goes along with a robot that walks, and is left alone otherwise."""

from __future__ import annotations

import time

import numpy as np
import viser

from equipoise.spatial import Array

EVERY = 0.1  # [s] between two corrections
SHARE = 0.35  # of what it is behind, a correction
STILL = 0.02  # [m] behind that nobody sees


class FollowingCamera:
    """Keeps what each page looks at where it was, as seen from the robot, while that walks."""

    def __init__(self, server: viser.ViserServer) -> None:
        self._server = server
        self._offsets: dict[int, Array] = {}
        self._next = 0.0

    def follow(self, place: Array, *, walks: bool) -> None:
        """Go along with a robot whose base is at `place` (3,) [m], if it walks."""
        if not walks:
            self._offsets = {}
            return
        now = time.perf_counter()
        if now < self._next:
            return
        self._next = now + EVERY
        for number, client in self._server.get_clients().items():
            camera = client.camera
            if camera.update_timestamp == 0.0:
                continue
            looked = np.array(camera.look_at)
            offset = self._offsets.setdefault(number, looked - place)
            behind = np.array([*(place + offset - looked)[:2], 0.0])
            if np.linalg.norm(behind) > STILL:
                camera.position = np.array(camera.position) + SHARE * behind
