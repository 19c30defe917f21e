"""The study ``basin``: what becomes of the machine, over two start states or parameters."""
