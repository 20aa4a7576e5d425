"""Results folders in, frames of judged attempts out."""
