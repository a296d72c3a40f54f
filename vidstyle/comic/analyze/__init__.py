"""TODO vidstyle/comic/analyze."""
