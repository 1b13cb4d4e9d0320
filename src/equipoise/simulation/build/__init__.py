"""From a scenario to the objects of a run: one file a kind of thing."""
