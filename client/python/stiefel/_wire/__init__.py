"""The calls: connection, streams, and the readers of replies."""
