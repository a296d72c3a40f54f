"""The GPU renderer: styles run with OpenGL."""
