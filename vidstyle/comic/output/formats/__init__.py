"""Kinds of files that pages go into: one file each, with a `content` of the sheets, and `SEVERAL`."""
