"""The designer: a style built out of blocks on a page of this machine."""
