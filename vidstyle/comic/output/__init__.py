"""TODO vidstyle/comic/output."""
