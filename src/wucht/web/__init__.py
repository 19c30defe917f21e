"""The live machine: a page without a server, in which a machine moves and answers while the hand still moves.

Python prepares it: the machine, what can be moved within which limits, what is drawn. The page itself is TypeScript.
"""
