"""The topic `certificates` of the report; its one small figure is drawn in `section`."""
