"""What moves in front of the background of a shot: where it is, how sharp, and in which pose."""
