"""The browser viewer: replay of a log, a running simulation, a robot of one's own.

It reads logs, places and robots; nothing of the package imports it except the command line.
"""
