"""The whole controller in one object, and the tick that runs it."""
