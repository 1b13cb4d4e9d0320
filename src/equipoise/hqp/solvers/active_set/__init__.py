"""Our own hierarchical active-set solver: exact for eq. (15), compiled, started where it ended."""
