"""TODO vidstyle/media/write."""
