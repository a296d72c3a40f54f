"""TODO vidstyle/gpu/compile."""
