"""The motion between two events of contacts: its modes are data of one compiled right-hand side."""
