"""Names of looks: what one sees of a picture, its colours, and how two looks differ."""
