"""What engines say of loose objects that have none."""

from __future__ import annotations

import pinocchio as pin

from equipoise.errors import NameNotFoundError
from equipoise.spatial import Array


class NoObjects:
    """An engine without bodies that move freely."""

    @property
    def object_names(self) -> tuple[str, ...]:
        """No names."""
        return ()

    def object_pose(self, name: str) -> pin.SE3:
        """Raise: `NameNotFoundError`."""
        raise NameNotFoundError("loose object", name, self.object_names)

    def object_twist(self, name: str) -> Array:
        """Raise: `NameNotFoundError`."""
        raise NameNotFoundError("loose object", name, self.object_names)
