"""A robot in another process: the plant at the far end, the loop that drives it."""
