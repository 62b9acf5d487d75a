"""Helpers of the results: equality, files and diagrams."""
