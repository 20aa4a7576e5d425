"""The promise that every solver keeps, the registry, and the call that puts a question to one."""
