"""The parts of a command line: commands with grouped help, options, paths, the configuration file."""
