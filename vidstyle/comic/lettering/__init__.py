"""TODO vidstyle/comic/lettering."""
