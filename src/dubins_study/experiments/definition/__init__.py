"""What an experiment's TOML file may contain, and the messages for invalid files."""
