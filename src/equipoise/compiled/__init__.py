"""How kernels are compiled and kept, and the memory they work in."""

from equipoise.compiled.compilation import announce, compiled, entrance, inlined
from equipoise.compiled.scratch import scratch, scratch_matrix

__all__ = ["announce", "compiled", "entrance", "inlined", "scratch", "scratch_matrix"]
