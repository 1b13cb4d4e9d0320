"""A run as Foxglove reads it without a line of code: public schemas, added to the log."""
