"""Capture from cameras, screens, microphones, pipes and network streams."""
