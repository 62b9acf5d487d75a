"""What a caller gives: numbers with or without units, and the shapes of arrays."""
