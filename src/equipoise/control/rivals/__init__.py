"""Rivals of the shipped law: published controllers that know a nominal model of the dynamics."""
