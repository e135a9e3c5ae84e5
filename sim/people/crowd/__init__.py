"""People among people: how they walk so that no two of them ever overlap."""
