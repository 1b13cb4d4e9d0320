"""How much of a control period in MuJoCo is `mj_step`: `python benchmarks/engine_share.py [NAME]`.

NAME is a scenario; by default tray, tray_real and telephone. Ends with 1 where it is below half.
"""

from __future__ import annotations

import sys

from equipoise.bench.engine_share import engine_rows, step_share


def main() -> None:
    """Time and print."""
    passed = True
    for scenario in sys.argv[1:] or ("tray", "tray_real", "telephone"):
        rows = engine_rows(scenario)
        for row in rows:
            print(f"{row.name:<36}{row.median_us:8.1f} us{row.p99_us:8.1f} us  {row.remark}")
        passed = passed and step_share(rows) > 0.5
    sys.exit(0 if passed else 1)


if __name__ == "__main__":
    main()
