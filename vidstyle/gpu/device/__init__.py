"""TODO vidstyle/gpu/device."""
