"""The parts of `stiefel.sweep`."""
