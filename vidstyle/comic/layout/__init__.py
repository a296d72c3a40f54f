"""TODO vidstyle/comic/layout."""
