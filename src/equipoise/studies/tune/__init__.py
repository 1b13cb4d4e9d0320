"""Gains found on an ensemble of runs and judged on others, or refused."""
