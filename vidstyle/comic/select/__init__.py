"""Selection of key frames: scores, choice and framing."""
