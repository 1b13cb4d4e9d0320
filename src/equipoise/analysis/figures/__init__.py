"""Figures of a run, one file a figure."""
