"""The run around the controller: simulated robot, loop, recorder, operator."""
