"""What the program shows in a terminal: messages, progress and pictures."""
