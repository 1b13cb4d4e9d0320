"""Who carries the base: the wrench that has no motor, shared out over the supports."""
