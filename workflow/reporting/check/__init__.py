"""Is a finished study the one that was made before? Results beside small stored references.

`quantities` says what is compared and how closely, in one list for a whole study. A reference holds
the same quantities, thinned out, and `compare` puts the two beside each other.
"""
