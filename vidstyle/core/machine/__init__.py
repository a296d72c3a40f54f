"""This machine: its cores, memory and control groups, the user's cache folder, installed versions."""
