"""Files for the workshop: lists of points to mill, CAD files and cam tables of controllers, each read back and compared."""
