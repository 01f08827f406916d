"""From a recording to its contacts and unbroken arcs."""
