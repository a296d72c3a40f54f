"""The style that is being built: its content, what can be done to it, and its history."""
