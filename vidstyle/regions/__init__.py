"""Detection and tracking of faces in pictures and films, and finer detail in faces."""
