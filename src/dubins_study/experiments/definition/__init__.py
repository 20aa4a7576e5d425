"""What an experiment's TOML file may say, and the messages for what it may not."""
