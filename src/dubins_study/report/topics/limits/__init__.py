"""The topic `limits` of the report; its texts and tables need no numbers of rows."""
