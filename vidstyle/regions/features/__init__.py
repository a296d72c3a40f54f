"""Features: eyes, nose and mouth of small faces, which a style would lose, drawn over its result."""
