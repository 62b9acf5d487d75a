"""The closed forms of stiefel.manifold."""
