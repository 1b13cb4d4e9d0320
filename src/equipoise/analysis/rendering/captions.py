"""Words on a picture: a line at its foot, and what the arrows mean."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np

from equipoise.analysis.rendering.run_pictures import MEASURED, WANTED
from equipoise.optional import require_package

INK, HALO = (45, 50, 58), (232, 237, 242)
SHARE = 0.030  # of a picture's height that a line of text takes


def write_caption(image: np.ndarray, left: str, right: str = "", *, arrows: bool = False) -> None:
    """Write a line at the foot of an image (height, width, 3) of bytes, in place.

    `arrows` adds what their colours mean.
    """
    require_package("PIL", "plot", "a caption")
    require_package("matplotlib", "plot", "the font of a caption")
    from PIL import Image, ImageDraw

    height, width, _ = image.shape
    size = max(11, round(SHARE * height))
    picture = Image.fromarray(image)
    draw = ImageDraw.Draw(picture)
    font, rim, foot = _font(size), size, height - 1.9 * size
    room = width - 4 * rim - draw.textlength(right, font=font)
    while left and draw.textlength(left, font=font) > room:
        left = left[:-2].rstrip() + "…" if len(left) > 2 else ""
    halo = {"font": font, "stroke_width": max(1, size // 8), "stroke_fill": HALO}
    draw.text((rim, foot), left, INK, **halo)
    draw.text((width - rim - draw.textlength(right, font=font), foot), right, INK, **halo)
    if arrows:
        y, x = float(rim), float(rim)
        for rgb, text in ((MEASURED, "force on the robot"), (WANTED, "wanted")):
            colour = tuple(round(255 * float(c)) for c in rgb)
            draw.line([(x, y + 0.6 * size), (x + 1.6 * size, y + 0.6 * size)], colour, size // 4)
            draw.text((x + 2.1 * size, y), text, INK, **halo)
            x += 2.1 * size + draw.textlength(text, font=font) + 1.5 * size
    image[:] = np.asarray(picture)


@lru_cache(maxsize=8)
def _font(size: int) -> Any:
    from matplotlib import get_data_path
    from PIL import ImageFont

    return ImageFont.truetype(f"{get_data_path()}/fonts/ttf/DejaVuSans.ttf", size)
