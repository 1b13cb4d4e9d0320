"""Rigid bodies with rigid bilateral contacts, equation (8)."""
