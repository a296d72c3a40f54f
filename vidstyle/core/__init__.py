"""Pictures and planes, and the compiled loops that everything else is built on."""
