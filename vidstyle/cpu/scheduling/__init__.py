"""Which nodes of a style are computed together in bands, and which are stored as planes."""
