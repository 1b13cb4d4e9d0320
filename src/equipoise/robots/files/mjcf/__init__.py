"""Reads robots written for MuJoCo: a bounded text, MuJoCo's own model of it, ours, and a proof."""
