"""Names of version 0.1: distances are in `equipoise.collision`."""

from equipoise.renamed import old_names_of

__getattr__ = old_names_of(__name__)
