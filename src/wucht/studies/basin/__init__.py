"""The study ``basin``: outcomes of a machine over two start states or parameters."""
