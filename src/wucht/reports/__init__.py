"""Reports: results as one page of HTML to send, that prints on A4 and opens without a network."""
