"""TODO vidstyle/comic/select."""
