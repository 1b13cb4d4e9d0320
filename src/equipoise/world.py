"""Names of version 0.1: bodies and scenes are in `equipoise.collision`."""

from equipoise.renamed import old_names_of

__getattr__ = old_names_of(__name__)
