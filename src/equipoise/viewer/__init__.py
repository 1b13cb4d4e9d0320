"""The browser viewer: replay of a log, a running simulation, a robot of one's own.

It reads logs, setup and robots; nothing of the package imports it except the command line.
"""

from importlib.util import find_spec

from equipoise.errors import InputError

if find_spec("viser") is None:
    raise InputError(
        "The viewer needs viser, which is not installed",
        remedy="Install it: pip install 'equipoise[viewer]'",
    )
