"""Make the tables that ship with blocks."""
