"""Choose the key frames: scoring, the choice itself, and the options of both."""
