"""Trajectories in the files of other tools."""
