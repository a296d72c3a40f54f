"""The page of the designer: its server, its messages, and the pictures that it is sent."""
