"""Drag and ask: a robot whose hands can be dragged in the browser, and what stops them in words."""
