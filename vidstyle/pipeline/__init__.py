"""Render a film: read, stylize and write in three threads, with progress and cancellation."""
