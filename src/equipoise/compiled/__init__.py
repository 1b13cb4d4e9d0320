"""How kernels are compiled and kept, and the memory they work in."""

from equipoise.compiled.compilation import compiled, entrance, inlined, specialised
from equipoise.compiled.scratch import scratch, scratch_matrix
from equipoise.compiled.stages import Stage
from equipoise.compiled.watching import COST, watch_compilation

__all__ = [
    "COST",
    "Stage",
    "compiled",
    "entrance",
    "inlined",
    "scratch",
    "scratch_matrix",
    "specialised",
    "watch_compilation",
]
