"""Our bytes of `LowState_` and `LowCmd_` against Unitree's own Python SDK, in both directions.

    python -m venv sdk && sdk/bin/pip install unitree_sdk2
    python benchmarks/unitree_sdk.py --python sdk/bin/python

The SDK unpacks messages that we packed, computes its checksum of them and packs them again; then it
packs messages of its own, which we unpack. Every byte has to agree.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

WORKER = """
import dataclasses, importlib.util, platform, random, sys, types
from pathlib import Path
sdk = types.ModuleType("unitree_sdk2py")  # its own first file imports what the wheel lacks
sdk.__path__ = list(importlib.util.find_spec("unitree_sdk2py").submodule_search_locations)
sys.modules["unitree_sdk2py"] = sdk
from unitree_sdk2py.idl.unitree_hg.msg.dds_ import LowCmd_, LowState_
from unitree_sdk2py.idl import default
from unitree_sdk2py.utils.crc import CRC

platform.system = lambda: ""  # the SDK's own Python: its library may not be in the wheel
folder, crc, random = Path(sys.argv[1]), CRC(), random.Random(1)
wrong = checked = 0
for name, kind in (("state", LowState_), ("cmd", LowCmd_)):
    for path in sorted(folder.glob(name + "_ours_*")):
        packet = path.read_bytes()
        message = kind.deserialize(packet)
        checked += 1
        wrong += crc.Crc(message) != message.crc or message.serialize() != packet
print(checked, wrong)

def fill(message):
    for field in dataclasses.fields(message):
        value = getattr(message, field.name)
        if isinstance(value, (list, tuple)):
            setattr(message, field.name, [one_of(one, field.name) for one in value])
        else:
            setattr(message, field.name, one_of(value, field.name))
    return message

def one_of(value, name):
    if dataclasses.is_dataclass(value):
        return fill(value)
    if isinstance(value, float):
        return random.uniform(-50.0, 50.0)
    return random.randrange(100)

for name, make in (
    ("state", default.unitree_hg_msg_dds__LowState_), ("cmd", default.unitree_hg_msg_dds__LowCmd_),
):
    for k in range(int(sys.argv[2])):
        message = fill(make())
        message.crc = crc.Crc(message)
        (folder / f"{name}_theirs_{k:04d}").write_bytes(message.serialize())
        motor = message.motor_state if name == "state" else message.motor_cmd
        tau = [one.tau_est if name == "state" else one.tau for one in motor]
        (folder / f"{name}_numbers_{k:04d}").write_text(" ".join(map(repr, tau)))
"""


def main() -> None:
    """Exchange messages with the SDK, print what agrees."""
    import numpy as np

    from equipoise.wire.unitree.layout import LOW_CMD, LOW_STATE, Message, fields_of

    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--python", required=True, help="Python that has unitree_sdk2")
    parser.add_argument("--messages", type=int, default=300, help="of each kind and direction")
    given = parser.parse_args()
    random, layouts = np.random.default_rng(0), {"state": LOW_STATE, "cmd": LOW_CMD}
    with TemporaryDirectory() as place:
        folder = Path(place)
        for name, layout in layouts.items():
            message = Message(layout)
            motors = message.fields["motor_state" if name == "state" else "motor_cmd"]
            for k in range(given.messages):
                for field in motors.dtype.names:
                    kind = motors[field].dtype.kind
                    size = motors[field].shape
                    motors[field] = (
                        random.normal(size=size) if kind == "f" else random.integers(0, 100, size)
                    )
                message.fields["reserve"] = random.integers(0, 1 << 32, 4)
                if name == "state":
                    message.fields["tick"] = random.integers(0, 1 << 32)
                    message.fields["imu_state"]["quat_wxyz"] = random.normal(size=4)
                    message.fields["wireless_remote"] = random.integers(0, 256, 40)
                (folder / f"{name}_ours_{k:04d}").write_bytes(message.packet())
        command = [given.python, "-c", WORKER, place, str(given.messages)]
        said = subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True).stdout
        checked, wrong = map(int, said.split())
        print(f"of ours the SDK found {checked - wrong} of {checked} equal, byte and checksum")
        theirs = 0
        for name, layout in layouts.items():
            for path in sorted(folder.glob(f"{name}_theirs_*")):
                fields = fields_of(path.read_bytes(), layout)
                numbers = path.with_name(path.name.replace("theirs", "numbers")).read_text()
                tau = np.array(numbers.split(), dtype=float).astype(np.float32)
                key = ("motor_state", "tau_est") if name == "state" else ("motor_cmd", "tau")
                good = fields is not None and (fields[key[0]][key[1]] == tau).all()
                theirs += bool(good)
        print(f"of the SDK's we found {theirs} of {2 * given.messages} whole, and their torques")
    sys.exit(bool(wrong or theirs != 2 * given.messages or checked != 2 * given.messages))


if __name__ == "__main__":
    main()
