"""What `dubins-study solve` asks and says: words to a question, an answer to text."""
