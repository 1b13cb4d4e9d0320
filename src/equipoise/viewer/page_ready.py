"""Asking a page how far it has come with what it was sent: it answers when a frame begins."""

from __future__ import annotations

import viser

FRAMES = 3  # that a page begins until what it was sent is drawn
PATIENCE = 5.0  # [s] for a page to answer while it sets itself up


def has_begun_frame(client: viser.ClientHandle, seconds: float) -> bool:
    """Wait until a page has taken in what it was sent, at most some seconds; False if it left."""
    try:
        client.local_storage.get_item("equipoise", timeout=seconds)
    except TimeoutError:
        return True
    except RuntimeError as error:  # it left, or it is not allowed to store anything: an answer too
        return "disconnected" not in str(error)
    return True


def has_drawn(client: viser.ClientHandle) -> bool:
    """Wait until a page has drawn all that it was sent, but not for ever; False if it left.

    In the first frame it takes in what it was sent, in the second it draws it, and the third
    begins when that is done.
    """
    return all(has_begun_frame(client, PATIENCE) for _ in range(FRAMES))
