"""Floor and sky of every page: those of the films."""

from __future__ import annotations

import numpy as np
import viser

from equipoise.analysis.rendering.render import OUTDOORS

ROWS = 96  # of the picture that stands for the sky
LINE, SECTION = (205, 209, 214), (168, 174, 182)


def add_floor_and_sky(scene: viser.SceneApi) -> None:
    """Add a grid of 0.1 m and 0.5 m on z = 0, and a light sky behind everything."""
    scene.add_grid(
        "/floor",
        width=4.0,
        height=4.0,
        cell_size=0.1,
        section_size=0.5,
        plane="xy",
        cell_color=LINE,
        section_color=SECTION,
    )
    down = np.linspace(0.0, 1.0, ROWS)[:, None, None]
    sky = (1.0 - down) * np.array(OUTDOORS.above) + down * np.array(OUTDOORS.horizon)
    image = np.round(255.0 * np.repeat(sky, 2, axis=1)).astype(np.uint8)
    scene.set_background_image(image, format="png")
