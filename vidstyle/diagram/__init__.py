"""A style as a graph of blocks, for people: as text, and as a picture."""
