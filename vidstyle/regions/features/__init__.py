"""What a style would lose of small faces: their tones, and eyes, nose and mouth, drawn over its result."""
