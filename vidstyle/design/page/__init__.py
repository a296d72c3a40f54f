"""The page of the designer: web server, messages and pictures."""
