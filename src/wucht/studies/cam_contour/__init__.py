"""The contour of a cam for its law and its follower: curvature, pressure angle, undercut, contact, and the points to mill."""
