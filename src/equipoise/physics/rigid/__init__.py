"""Rigid bodies with rigid contacts, equation (8): those that hold, and those that lift and land."""
