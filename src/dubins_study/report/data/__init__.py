"""Read results folders into frames of judged attempts."""
