"""TODO vidstyle/core."""
