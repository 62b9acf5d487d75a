"""The generated messages and stubs of `stiefel.v1`."""
