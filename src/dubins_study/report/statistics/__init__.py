"""Pure functions that compute numbers from rows."""
