"""TODO vidstyle/media/read."""
