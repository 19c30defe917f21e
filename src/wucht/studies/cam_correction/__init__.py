"""Study of the cam for a shaft that does not turn evenly: before, after, and the residual on another motion: 004."""
