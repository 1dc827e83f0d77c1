"""Tables of text as people, instruments and programs write them."""
