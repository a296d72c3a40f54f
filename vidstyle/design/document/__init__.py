"""The document of the designer: content, edits and history of a style."""
